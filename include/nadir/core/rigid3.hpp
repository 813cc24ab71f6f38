// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Rigid and similarity transforms. b_from_a maps x_in_a to x_in_b: x_in_b = b_from_a * x_in_a.
#pragma once

#include <Eigen/Geometry>

namespace nadir {

struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return {(rotation * other.rotation).normalized(), *this * other.translation};
  }
  Rigid3 inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
  bool is_finite() const { return rotation.coeffs().allFinite() && translation.allFinite(); }
};

struct Similarity3 {
  double scale = 1.0;
  Rigid3 rigid;

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rigid * (scale * x); }
  /// The pose of a camera after its map was moved by this similarity.
  Rigid3 operator*(const Rigid3& pose) const {
    return {(rigid.rotation * pose.rotation).normalized(), *this * pose.translation};
  }
  Similarity3 operator*(const Similarity3& other) const {
    return {scale * other.scale, *this * other.rigid};
  }
  Similarity3 inverse() const {
    const Eigen::Quaterniond back = rigid.rotation.conjugate();
    return {1 / scale, {back, -(back * rigid.translation) / scale}};
  }
};

/// cross_matrix(v) * w = v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  return Eigen::Matrix3d{{0, -v.z(), v.y()}, {v.z(), 0, -v.x()}, {-v.y(), v.x(), 0}};
}

}  // namespace nadir
