// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "nadir/core/frame.hpp"

namespace nadir::odometry {

/// How far what the right camera sees lies from the epipolar line of what the left one sees, px;
/// none at the epipole. Rays are undistorted, normalised.
inline std::optional<double> epipolar_distance_px(const CameraRig::Right& right,
                                                  const Eigen::Vector2d& left_ray,
                                                  const Eigen::Vector2d& right_ray) {
  const Eigen::Vector3d line = right.right_from_left.translation.cross(
      right.right_from_left.rotation * left_ray.homogeneous());
  const double slope = line.head<2>().norm();
  if (!(slope > 0)) return std::nullopt;
  return std::abs(line.dot(right_ray.homogeneous())) / slope * right.camera.fx;
}

}  // namespace nadir::odometry
