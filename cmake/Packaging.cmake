# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, and the Debian package of it.
include(GNUInstallDirs)
set(NADIR_CONFIG_FILE ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir/nadir.toml)
set(units ${PROJECT_BINARY_DIR}/systemd)
foreach(unit nadir.service nadir-replay@.service nadir-kiosk.service nadir-kiosk-screen.service)
  configure_file(systemd/${unit}.in ${units}/${unit} @ONLY)
endforeach()
foreach(file nadir.socket nadir-poweroff.path nadir-poweroff.service nadir.sysusers nadir.tmpfiles nadir-kiosk.sysusers)
  configure_file(systemd/${file} ${units}/${file} COPYONLY)
endforeach()

install(TARGETS nadir RUNTIME)
install(FILES config/nadir.toml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir)
install(FILES ${units}/nadir.service ${units}/nadir-replay@.service ${units}/nadir.socket ${units}/nadir-poweroff.path ${units}/nadir-poweroff.service DESTINATION lib/systemd/system)
install(FILES systemd/nadir.sysusers DESTINATION lib/sysusers.d RENAME nadir.conf)
install(FILES systemd/nadir.tmpfiles DESTINATION lib/tmpfiles.d RENAME nadir.conf)
install(FILES systemd/nadir.udev.rules DESTINATION lib/udev/rules.d RENAME 60-nadir.rules)

# The rest is of the package alone. Debian's policy wants manual and changelog gzipped, the latter in its own form, dated as the sources are.
set(NADIR_MAINTAINER "nadir contributors <nadir@example.org>" CACHE STRING "Who answers for the package")
set(documents ${PROJECT_BINARY_DIR}/packaging)
execute_process(COMMAND git log -1 --format=%cD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
  OUTPUT_VARIABLE changed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${documents}/changelog @ONLY CONTENT
  "nadir (@PROJECT_VERSION@) bookworm; urgency=medium\n\n  * What is new: NEWS.md.gz.\n\n -- @NADIR_MAINTAINER@  @changed@\n")
configure_file(CHANGELOG.md ${documents}/NEWS.md COPYONLY)
configure_file(packaging/nadir.1 ${documents}/nadir.1 COPYONLY)
execute_process(COMMAND gzip -9nkf changelog NEWS.md nadir.1 WORKING_DIRECTORY ${documents} COMMAND_ERROR_IS_FATAL ANY)
install(FILES ${documents}/nadir.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${documents}/changelog.gz ${documents}/NEWS.md.gz packaging/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The plugin for CSI cameras depends on the one libcamera that it was built with, and so is a package of its own.
set(CPACK_COMPONENTS_ALL nadir kiosk)
if(TARGET nadir_libcamera_plugin)
  list(APPEND CPACK_COMPONENTS_ALL libcamera)
  install(FILES ${documents}/changelog.gz packaging/copyright
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/nadir-libcamera${libcamera_VERSION} COMPONENT libcamera)
endif()
# The page on the board's own screen needs a browser, which most boards do without.
install(PROGRAMS packaging/kiosk/nadir-kiosk DESTINATION ${CMAKE_INSTALL_LIBEXECDIR} COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES ${units}/nadir-kiosk.service ${units}/nadir-kiosk-screen.service DESTINATION lib/systemd/system COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES packaging/kiosk/weston.ini DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/nadir COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES systemd/nadir-kiosk.sysusers DESTINATION lib/sysusers.d RENAME nadir-kiosk.conf COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES ${documents}/changelog.gz packaging/copyright
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/nadir-kiosk COMPONENT kiosk EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_NADIR_PACKAGE_NAME nadir)
set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_NAME nadir-libcamera${libcamera_VERSION})
set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_PROVIDES nadir-libcamera)
set(CPACK_COMPONENT_LIBCAMERA_DESCRIPTION
  "Lets nadir take images from cameras that the kernel shows to libcamera alone,
as those at a Raspberry Pi's ribbon connector.")
set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_DEPENDS "nadir (= ${PROJECT_VERSION}), libcamera-ipa")
set(CPACK_DEBIAN_KIOSK_PACKAGE_NAME nadir-kiosk)
set(CPACK_COMPONENT_KIOSK_DESCRIPTION
  "The board shows nadir's page on its own screen, full-screen, from the next
boot on: chromium in the Wayland compositor weston. For boards without a
desktop; it takes the place of the first console's login.")
set(CPACK_DEBIAN_KIOSK_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_KIOSK_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_KIOSK_PACKAGE_DEPENDS
  "nadir (>= ${PROJECT_VERSION}), chromium, curl, fonts-dejavu-core, kbd, libgl1-mesa-dri, libpam-systemd, systemd, weston (>= 10)")
set(CPACK_DEBIAN_KIOSK_PACKAGE_CONTROL_STRICT_PERMISSION ON)
foreach(file conffiles postinst prerm postrm)
  list(APPEND CPACK_DEBIAN_KIOSK_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/kiosk/${file})
endforeach()
set(CPACK_PACKAGE_CONTACT ${NADIR_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "live seabed map from underwater images")
set(CPACK_COMPONENT_NADIR_DESCRIPTION
  "Calibrated mono or stereo images of a diver's tablet or an ROV become a
trajectory, a sparse cloud, sequential mosaics and planar point clouds, shown
live in a browser and recorded for GIS and photogrammetry.

Installing it starts the service nadir, which maps what the cameras see.")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_NADIR_PACKAGE_DEPENDS systemd)
set(CPACK_DEBIAN_NADIR_PACKAGE_RECOMMENDS avahi-daemon)
set(CPACK_DEBIAN_NADIR_PACKAGE_SUGGESTS "ffmpeg, nadir-kiosk, nadir-libcamera${libcamera_VERSION}")
set(CPACK_DEBIAN_NADIR_PACKAGE_CONTROL_STRICT_PERMISSION ON)
foreach(file conffiles postinst prerm postrm)
  list(APPEND CPACK_DEBIAN_NADIR_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/${file})
endforeach()
# dpkg-shlibdeps knows the packages of this machine only: ./dev gives a cross build the list of the native one.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()
include(CPack)
