# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, and the Debian package of it.
include(GNUInstallDirs)
set(NADIR_CONFIG_FILE ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir/nadir.toml)
set(units ${PROJECT_BINARY_DIR}/systemd)
foreach(unit nadir.service nadir-replay@.service)
  configure_file(systemd/${unit}.in ${units}/${unit} @ONLY)
endforeach()
foreach(file nadir.socket nadir.sysusers nadir.tmpfiles)
  configure_file(systemd/${file} ${units}/${file} COPYONLY)
endforeach()

install(TARGETS nadir RUNTIME)
install(FILES config/nadir.toml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir)
install(FILES ${units}/nadir.service ${units}/nadir-replay@.service ${units}/nadir.socket DESTINATION lib/systemd/system)
install(FILES systemd/nadir.sysusers DESTINATION lib/sysusers.d RENAME nadir.conf)
install(FILES systemd/nadir.tmpfiles DESTINATION lib/tmpfiles.d RENAME nadir.conf)
install(FILES systemd/nadir.udev.rules DESTINATION lib/udev/rules.d RENAME 60-nadir.rules)
