// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The plugin linked to libcamera (libcamera.org/api-html), one source for 0.0.3 and what came
// after. The image's orientation is left as libcamera has it, upright by how the sensor is mounted.
#include "libcamera_plugin.h"

#include <libcamera/libcamera.h>

#include <exception>
#include <memory>
#include <string>

#include "fault.hpp"
#include "open_camera.hpp"

namespace {

using nadir::capture::plugin::OpenCamera;
using nadir::capture::plugin::write_text;

void open_camera(const NadirCameraWanted* wanted, NadirCameraOpened* opened) {
  *opened = {};
  std::unique_ptr<OpenCamera> camera;
  try {
    camera = std::make_unique<OpenCamera>();
    camera->start(*wanted, *opened);
    opened->camera = camera.release();
  } catch (const std::exception& error) {
    write_text(opened->fault, error.what());
  }
}

NadirCameraTaken take(void* camera, NadirCameraPicture* picture, NadirText* gone) {
  *picture = {};
  try {
    return static_cast<OpenCamera*>(camera)->take(*picture, *gone);
  } catch (const std::exception& error) {
    write_text(*gone, error.what());
    return NADIR_TAKEN_GONE;
  }
}

void give_back(void* camera, void* buffer) { static_cast<OpenCamera*>(camera)->give_back(buffer); }
void expose_camera(void* camera, double ms, double gain) {
  static_cast<OpenCamera*>(camera)->expose(ms, gain);
}
void stop(void* camera) { static_cast<OpenCamera*>(camera)->stop(); }
void close_camera(void* camera) { delete static_cast<OpenCamera*>(camera); }

}  // namespace

const NadirLibcameraPlugin* nadir_libcamera_plugin() {
  static const std::string version = libcamera::CameraManager::version();
  static const NadirLibcameraPlugin plugin{
      NADIR_LIBCAMERA_ABI, version.c_str(), open_camera, take,
      give_back,           expose_camera,   stop,        close_camera};
  return &plugin;
}
