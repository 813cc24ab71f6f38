# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# Everything comes from Debian packages; `./dev` installs them. One line each says which room it is for.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Ceres 2.1 REQUIRED)                      # odometry (self-calibration), revisit
find_package(PNG REQUIRED)                            # image_io
find_package(TIFF REQUIRED)                           # image_io
find_package(Boost 1.74 REQUIRED)                     # serve (Beast and Asio, header-only)
find_package(OpenSSL 3 REQUIRED)                       # serve
find_package(nlohmann_json 3.11 REQUIRED)             # record, app
find_package(CLI11 REQUIRED)                          # app
find_package(tomlplusplus 3.3 REQUIRED)                # app
find_package(yaml-cpp 0.7 REQUIRED)                   # calibration
find_package(pugixml 1.13 REQUIRED)                   # calibration
find_package(PkgConfig REQUIRED)
pkg_check_modules(geographiclib REQUIRED IMPORTED_TARGET geographiclib>=2.1)  # reference
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)      # image_io
pkg_check_modules(deflate REQUIRED IMPORTED_TARGET libdeflate)          # image_io, record
pkg_check_modules(systemd REQUIRED IMPORTED_TARGET libsystemd)          # app
pkg_check_modules(qrencode REQUIRED IMPORTED_TARGET libqrencode)        # app (nadir token)
pkg_check_modules(isal REQUIRED IMPORTED_TARGET libisal)                # image_io
pkg_check_modules(libcamera IMPORTED_TARGET libcamera)                  # capture's plugin, which is left out without it

# OpenCV module by module: its own CMake package asks for all of libopencv-dev, of which nadir uses five.
find_path(OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc flann features2d calib3d)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  add_library(opencv::${module} INTERFACE IMPORTED)
  target_include_directories(opencv::${module} SYSTEM INTERFACE ${OPENCV_INCLUDE})
  target_link_libraries(opencv::${module} INTERFACE ${OPENCV_${module}})
endforeach()

if(NADIR_TESTS)
  find_package(GTest REQUIRED)
endif()
