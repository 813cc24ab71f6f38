// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "triangulation.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace nadir::odometry {

using Eigen::Matrix3d, Eigen::Vector3d;

std::optional<Vector3d> triangulate(std::span<const Bearing> bearings) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Bearing& b : bearings) {
    const Rigid3 map_from_camera = b.camera_from_map.inverse();
    const Vector3d d = (map_from_camera.rotation * b.ray.homogeneous()).normalized();
    const Matrix3d across = Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right += across * map_from_camera.translation;
  }
  constexpr double kParallel = 1e-7;  // squared sine of 0.02 degrees
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(normal);
  if (!normal.allFinite() || !(eigen.eigenvalues()[0] > kParallel)) return std::nullopt;
  const Vector3d x = eigen.eigenvectors() *
                     (eigen.eigenvectors().transpose() * right).cwiseQuotient(eigen.eigenvalues());
  for (const Bearing& b : bearings) {
    if (!((b.camera_from_map * x).z() > 0)) return std::nullopt;
  }
  return x;
}

double parallax(const Rigid3& first_from_map, const Rigid3& second_from_map,
                const Vector3d& x_in_map) {
  const Vector3d a = x_in_map - first_from_map.inverse().translation;
  const Vector3d b = x_in_map - second_from_map.inverse().translation;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace nadir::odometry
