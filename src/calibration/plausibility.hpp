// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether numbers can belong to a camera that maps a seabed.
#pragma once

#include <optional>
#include <string>

#include "nadir/core/camera_model.hpp"

namespace nadir::calibration {

struct Doubt {
  std::string fault, remedy;
  bool about_rotation = false;  ///< of a pair, else about its translation
};

/// Focal lengths and principal point; none when plausible.
std::optional<Doubt> doubt_about_pinhole(const CameraModel& camera);
/// Distortion: nearly every pixel must belong to one ray only.
std::optional<Doubt> doubt_about_lens(const CameraModel& camera);
/// Baseline in metres, the right camera on the right, both looking the same way.
std::optional<Doubt> doubt_about_pair(const Rigid3& right_from_left);

}  // namespace nadir::calibration
