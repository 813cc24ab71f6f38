// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How the camera moves: where it will be, and how far the image went.
#pragma once

#include <span>

#include "map.hpp"
#include "resection.hpp"

namespace nadir::odometry {

struct Moment {
  Time time = 0;
  Rigid3 camera_from_map;
};

/// With the velocity between the last two moments, at most three steps on; where the last one was
/// when there is but one; none when there is none.
std::optional<Rigid3> predict(std::span<const Moment> track, Time time);

/// Median image motion since the last key frame, px.
double shift_since_last(const Map& map, const Resection& resection);

}  // namespace nadir::odometry
