// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/pair_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "features.hpp"
#include "nadir/core/check.hpp"
#include "resection.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

constexpr int kMinCorners = 60;      // of an image that is not blank
constexpr double kTolerance_px = 3;  // corners are good to 0.6 px, a doubtful calibration to more
constexpr int kCorners = 1000;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

Eigen::Matrix3d essential(const Rigid3& right_from_left) {
  const Eigen::Vector3d& t = right_from_left.translation;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return cross * right_from_left.rotation.toRotationMatrix();
}

double distance(const Eigen::Vector3d& line, const Eigen::Vector2d& point) {
  return std::abs(line.dot(point.homogeneous())) / line.head<2>().norm();
}

}  // namespace

PairFit pair_fit(const Frame& pair, const Features& left) {
  const CameraRig& rig = *pair.rig;
  NADIR_CHECK(rig.right.has_value() && !pair.right.empty(), pair.image);
  const CameraModel& camera = rig.right->camera;
  const Rigid3& right_from_left = rig.right->right_from_left;
  const Eigen::Matrix3d line_from_ray = essential(right_from_left);
  const Features right = detect_features(pair.right, camera, left.size());
  PairFit fit;
  fit.right_blank = right.size() < kMinCorners;
  std::vector<double> distances_px;
  for (const auto& [i, k] : correspond(left, right, camera).pairs) {
    ++fit.matches;
    const Eigen::Vector2d& a = left.rays[static_cast<std::size_t>(i)];
    const Eigen::Vector2d& b = right.rays[static_cast<std::size_t>(k)];
    distances_px.push_back(camera.fx * distance(line_from_ray * a.homogeneous(), b));
    const std::array<Bearing, 2> bearings{{{{}, a}, {right_from_left, b}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    const auto again = ray_of(*x), other = ray_of(right_from_left * *x);
    if (again && other && (*again - a).norm() * rig.left.fx < kTolerance_px &&
        (*other - b).norm() * camera.fx < kTolerance_px) {
      ++fit.allowed;
    }
  }
  fit.epipolar_px = median(std::move(distances_px));
  return fit;
}

PairFit pair_fit(const Frame& pair) {
  return pair_fit(pair, detect_features(pair.grey, pair.rig->left, kCorners));
}

}  // namespace nadir::odometry
