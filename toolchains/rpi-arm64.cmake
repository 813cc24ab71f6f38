# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# Cross build for 64-bit Raspberry Pi OS or Debian 12 arm64 with Debian's g++-aarch64-linux-gnu.
# NADIR_SYSROOT: a Debian 12 arm64 tree, as toolchains/sysroot makes it. Tests run in it, emulated; `./dev deb arm64` does all of this.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES NADIR_SYSROOT)
if(NOT NADIR_SYSROOT)
  set(NADIR_SYSROOT $ENV{NADIR_SYSROOT})
endif()
if(NOT IS_DIRECTORY "${NADIR_SYSROOT}")
  message(FATAL_ERROR "set NADIR_SYSROOT to a Debian 12 arm64 tree (see ${CMAKE_CURRENT_LIST_FILE}); '${NADIR_SYSROOT}' is none")
endif()
set(CMAKE_SYSROOT ${NADIR_SYSROOT})
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L ${NADIR_SYSROOT})
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${NADIR_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${NADIR_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${NADIR_SYSROOT}/usr/share/pkgconfig)
