// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_errors.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace nadir::odometry {
namespace {

Eigen::RowVector3d up_in_camera(const Rigid3& camera_from_map) {
  return (camera_from_map.rotation * Eigen::Vector3d::UnitZ()).transpose();
}

}  // namespace

double heading_error(const Eigen::Quaterniond& map_from_camera, const Rigid3& camera_from_map) {
  const Eigen::Quaterniond turn =
      camera_from_map.rotation.conjugate() * map_from_camera.conjugate();
  return std::remainder(2 * std::atan2(turn.z(), turn.w()), 2 * M_PI);
}

SensorError error_of(const Adjustment::Heading& heading, const Rigid3& camera_from_map) {
  const double weight = kTypical_px / heading.sigma;
  SensorError error;
  error.px = weight * heading_error(heading.map_from_camera, camera_from_map);
  error.by_pose.head<3>() = -weight * up_in_camera(camera_from_map);
  return error;
}

SensorError error_of(const Adjustment::Height& height, const Rigid3& camera_from_map) {
  const double weight = kTypical_px / height.sigma;
  SensorError error;
  error.px = weight * (camera_from_map.inverse().translation.z() - height.z);
  error.by_pose.tail<3>() = -weight * up_in_camera(camera_from_map);
  return error;
}

SensorError error_of(const Adjustment::Range& range, const Rigid3& camera_from_map,
                     const Eigen::Vector3d& x_in_map) {
  const Eigen::Vector3d x = camera_from_map * x_in_map;
  SensorError error;
  if (!(x.z() > 0)) return error;
  const double weight = kTypical_px / range.sigma;
  error.px = weight * std::log(x.z() / range.depth);
  const double by_depth = weight / x.z();
  error.by_pose << by_depth * x.y(), -by_depth * x.x(), 0, 0, 0, by_depth;
  error.by_point = by_depth * camera_from_map.rotation.toRotationMatrix().row(2);
  return error;
}

}  // namespace nadir::odometry
