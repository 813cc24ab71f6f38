// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The first map of a sub-map from its first n key images (paper 3.2).
#pragma once

#include <span>

#include "map.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {

/// In the odometry frame: first camera at the origin; metric from a pair, else the median depth of
/// the ground is 1. None when the images do not fit together as one rigid scene seen from different
/// places.
std::optional<Map> start_map(std::span<const std::shared_ptr<const View>> views,
                             const Config& config);

}  // namespace nadir::odometry
