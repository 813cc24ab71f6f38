// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "nadir/capture/source.hpp"
#include "nadir/core/check.hpp"

namespace nadir::capture {

void Config::check() const {
  if (scale != 1 && scale != 0.5 && scale != 0.25) {
    throw InputError("capture.scale = " + std::to_string(scale) + ": must be 1, 0.5 or 0.25");
  }
  for (const auto& [key, angle] : {std::pair{"roll", mounting_roll_deg},
                                   {"pitch", mounting_pitch_deg},
                                   {"yaw", mounting_yaw_deg}}) {
    if (std::abs(angle) <= 180) continue;
    throw InputError("capture.mounting_" + std::string(key) + "_deg = " + std::to_string(angle) +
                     ": must be -180 to 180");
  }
  require_setting(video_rate_hz >= 0 && video_rate_hz <= 1000, "capture.video_rate_hz",
                  "0 (all images) to 1000 Hz");
}

Eigen::Quaterniond Config::body_from_camera() const {
  constexpr double kRadians = std::numbers::pi / 180;
  const Attitude turned{kRadians * mounting_roll_deg, kRadians * mounting_pitch_deg,
                        kRadians * mounting_yaw_deg};
  return turned.ned_from_body() * CameraRig().body_from_camera;
}

}  // namespace nadir::capture
