// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What AHRS, depth sensor and lasers say of a window, for its adjustment.
#pragma once

#include <vector>

#include "map.hpp"
#include "nadir/odometry/bundle_adjustment.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {

/// What the AHRS says of an image; none without attitude.
std::optional<Eigen::Quaterniond> enu_from_camera(const Frame& frame);

/// key_frames and points: those of the adjustment's images and points, the points in order.
/// Heading, height and range count once the map knows how far the sensor is off in it.
void add_sensor_factors(const Map& map, const std::vector<int>& key_frames,
                        const std::vector<int>& points, const Config& config, Adjustment& a);

/// From a key frame that leaves the window: how far each sensor is off.
void learn_offsets(Map& map, const KeyFrame& key_frame, int index);

}  // namespace nadir::odometry
