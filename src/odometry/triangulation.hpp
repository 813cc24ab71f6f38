// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Intersection of image rays in space.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "nadir/core/rigid3.hpp"

namespace nadir::odometry {

struct Bearing {
  Rigid3 camera_from_map;
  Eigen::Vector2d ray;  ///< normalised undistorted image coordinates
};

/// The point nearest to two or more rays (least squares); none when it is behind a camera, or the
/// rays meet nowhere (parallel, not finite).
std::optional<Eigen::Vector3d> triangulate(std::span<const Bearing> bearings);

/// The angle under which two cameras see a point, radians.
double parallax(const Rigid3& first_from_map, const Rigid3& second_from_map,
                const Eigen::Vector3d& x_in_map);

/// Where a point in a camera frame appears, normalised coordinates; none behind the camera.
inline std::optional<Eigen::Vector2d> ray_of(const Eigen::Vector3d& x_in_camera) {
  if (!(x_in_camera.z() > 1e-9)) return std::nullopt;
  return Eigen::Vector2d(x_in_camera.head<2>() / x_in_camera.z());
}

}  // namespace nadir::odometry
