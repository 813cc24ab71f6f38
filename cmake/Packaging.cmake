# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where.
include(GNUInstallDirs)
set(NADIR_CONFIG_FILE ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir/nadir.toml)
configure_file(systemd/nadir-replay@.service.in systemd/nadir-replay@.service @ONLY)
install(TARGETS nadir RUNTIME)
install(FILES config/nadir.toml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/nadir)
install(FILES ${PROJECT_BINARY_DIR}/systemd/nadir-replay@.service DESTINATION lib/systemd/system)
