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
  require(relocalise_key_frames >= 1 && relocalise_key_frames <= 100, "relocalise_key_frames",
          relocalise_key_frames, "1 to 100");
}

}  // namespace nadir::odometry
