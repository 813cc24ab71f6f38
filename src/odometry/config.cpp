// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "nadir/core/check.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {
namespace {

template <class Value>
void require(bool holds, const char* key, Value value, const char* range) {
  if (holds) return;
  std::ostringstream message;
  message << "odometry." << key << " = " << value << " is out of range: choose " << range;
  throw InputError(message.str());
}

}  // namespace

void Config::check() const {
  require(initial_images >= 3 && initial_images <= 9, "initial_images", initial_images, "3 to 9");
  require(window >= 3 && window <= 50, "window", window, "3 to 50");
  require(features >= 200 && features <= 20000, "features", features, "200 to 20000");
  require(tie_points >= 100 && tie_points <= 5000, "tie_points", tie_points, "100 to 5000");
  require(key_frame_shift > 0 && key_frame_shift < 0.5, "key_frame_shift", key_frame_shift,
          "more than 0, less than 0.5 of the shorter side");
  require(min_parallax_deg > 0.1 && min_parallax_deg < 20, "min_parallax_deg", min_parallax_deg,
          "0.1 to 20 degrees");
  require(attitude_sigma_deg == 0 || (attitude_sigma_deg >= 0.01 && attitude_sigma_deg <= 45),
          "attitude_sigma_deg", attitude_sigma_deg,
          "0.01 to 45 degrees, or 0 to leave the AHRS out");
  require(heading_sigma_deg == 0 || (heading_sigma_deg >= 0.01 && heading_sigma_deg <= 180),
          "heading_sigma_deg", heading_sigma_deg,
          "0.01 to 180 degrees, or 0 to leave the heading out");
  require(depth_sigma_m == 0 || (depth_sigma_m >= 0.0001 && depth_sigma_m <= 100), "depth_sigma_m",
          depth_sigma_m, "0.0001 to 100 metres, or 0 to leave the depth out");
  require(range_sigma == 0 || (range_sigma >= 0.0001 && range_sigma <= 1), "range_sigma",
          range_sigma, "0.0001 to 1, or 0 to leave the lasers out");
  require(relocalise_key_frames >= 1 && relocalise_key_frames <= 100, "relocalise_key_frames",
          relocalise_key_frames, "1 to 100");
  require(weak_tie_points >= 0, "weak_tie_points", weak_tie_points, "0 or more");
  require(weak_quadrant >= 0, "weak_quadrant", weak_quadrant, "0 or more");
  require(weak_track_length >= 0, "weak_track_length", weak_track_length, "0 or more");
  require(weak_rms_px > 0, "weak_rms_px", weak_rms_px, "more than 0");
  require(weak_sharpness >= 0, "weak_sharpness", weak_sharpness, "0 or more");
  require(weak_dark >= 0 && weak_dark <= 255, "weak_dark", weak_dark, "0 to 255");
  require(weak_bright >= 0 && weak_bright <= 255, "weak_bright", weak_bright, "0 to 255");
}

}  // namespace nadir::odometry
