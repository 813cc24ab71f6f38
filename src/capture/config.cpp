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
  require_setting(rate_hz >= 0 && rate_hz <= 1000, "capture.rate_hz", "0 (all images) to 1000 Hz");
  require_setting(exposure_ms >= 0 && exposure_ms <= 1000, "capture.exposure_ms",
                  "0 (automatic) to 1000 ms");
  require_setting(gain >= -1, "capture.gain", "-1 (automatic) or more");
  require_setting(focus >= -1, "capture.focus", "-1 (as it is) or more");
  require_setting(max_blur_px > 0 && max_blur_px <= 100, "capture.max_blur_px", "up to 100 px");
  require_setting(max_skew_ms > 0 && max_skew_ms <= 1000, "capture.max_skew_ms", "up to 1000 ms");
  require_setting(!camera.empty(), "capture.camera", "a camera's name, or \"auto\"");
  for (const std::string* name : {&camera, &camera_right}) {
    if (camera_right.empty() || name->find("/dev/video") != 0) continue;
    throw InputError(*name +
                     " may be the other camera of the pair after the next start; name each by its "
                     "path in /dev/v4l/by-path, or by its serial number");
  }
  if (!camera_right.empty() &&
      (camera == camera_right || camera == "auto" || camera == "libcamera:auto")) {
    throw InputError("capture.camera = '" + camera + "' and capture.camera_right = '" +
                     camera_right + "' do not tell the two cameras of a pair apart; name both");
  }
}

Eigen::Quaterniond Config::body_from_camera() const {
  constexpr double kRadians = std::numbers::pi / 180;
  const Attitude turned{kRadians * mounting_roll_deg, kRadians * mounting_pitch_deg,
                        kRadians * mounting_yaw_deg};
  return turned.ned_from_body() * CameraRig().body_from_camera;
}

}  // namespace nadir::capture
