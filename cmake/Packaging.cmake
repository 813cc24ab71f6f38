# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where.
include(GNUInstallDirs)
install(TARGETS nadir RUNTIME)
install(FILES config/nadir.toml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/nadir)
install(FILES systemd/nadir-replay@.service DESTINATION lib/systemd/system)
