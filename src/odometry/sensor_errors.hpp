// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What sensors say against what an adjustment has, as residuals in pixels. Up is the map's z.
#pragma once

#include <Eigen/Core>

#include "nadir/odometry/bundle_adjustment.hpp"

namespace nadir::odometry {

struct SensorError {
  double px = 0;
  /// By (rotation vector, translation) of camera_from_map, small and applied from the left.
  Eigen::Matrix<double, 1, 6> by_pose = Eigen::Matrix<double, 1, 6>::Zero();
  Eigen::RowVector3d by_point = Eigen::RowVector3d::Zero();
};

SensorError error_of(const Adjustment::Heading& heading, const Rigid3& camera_from_map);
SensorError error_of(const Adjustment::Height& height, const Rigid3& camera_from_map);
/// Zero where the point is not in front of the camera.
SensorError error_of(const Adjustment::Range& range, const Rigid3& camera_from_map,
                     const Eigen::Vector3d& x_in_map);

/// Turn of the map about up between a camera's orientation in it and the measured one, -pi to pi.
double heading_error(const Eigen::Quaterniond& map_from_camera, const Rigid3& camera_from_map);

/// Pixels of an error of one sigma: the cost is in pixels, which tie points hold to a fifth of one.
constexpr double kTypical_px = 0.2;

}  // namespace nadir::odometry
