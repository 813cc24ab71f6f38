// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which of the formats that can be read a camera is to give.
#pragma once

#include <libcamera/libcamera.h>

#include <cstdint>
#include <memory>

#include "libcamera_plugin.h"

namespace nadir::capture::plugin {

// A pair's pictures wait for each other while the camera fills the next.
constexpr unsigned kBuffers = 6;

struct Choice {
  std::unique_ptr<libcamera::CameraConfiguration> configuration;  ///< null: none fits
  std::uint32_t v4l2 = 0;
};

/// The first of those wanted that the camera has at that size; throws Fault when there is none.
Choice choose(libcamera::Camera& camera, const NadirCameraWanted& wanted);

}  // namespace nadir::capture::plugin
