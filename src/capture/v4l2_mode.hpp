// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Sets a V4L2 device to the size, format, rate and controls wanted.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "camera.hpp"

namespace nadir::capture {

/// The layout of a pixel format of V4L2; none for what cannot be decoded here.
std::optional<Encoding> encoding_of(std::uint32_t pixel_format);

/// All that have one, in the order of preference.
std::vector<std::uint32_t> known_formats();

struct V4l2Mode {
  Encoding encoding;
  double rate_hz = 0;  ///< as the driver set it; 0: unknown
  std::string fault;   ///< empty when set
};

/// Of the formats it offers at that size the first that is fast enough, in the order NV12, YUYV,
/// JPEG, RGB, Bayer of 8 and 10 bits, grey; else the fastest.
V4l2Mode set_mode(int device, const CameraMode& wanted);

/// What the camera would not be set to; streams all the same.
std::vector<std::string> set_controls(int device, const CameraMode& wanted);

/// After set_controls(); none unless its exposure can be set, or when a fixed one was wanted.
std::optional<Camera::Exposing> exposing(int device, const CameraMode& wanted);
void expose(int device, const Exposure& exposure);

}  // namespace nadir::capture
