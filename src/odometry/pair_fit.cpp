// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/pair_fit.hpp"

#include <utility>
#include <vector>

#include "epipolar.hpp"
#include "features.hpp"
#include "median.hpp"
#include "nadir/core/check.hpp"
#include "resection.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

constexpr int kMinCorners = 60;      // of an image that is not blank
constexpr double kTolerance_px = 3;  // corners are good to 0.6 px, a doubtful calibration to more
constexpr int kCorners = 1000;

}  // namespace

PairFit pair_fit(const Frame& pair, const Features& left) {
  const CameraRig& rig = *pair.rig;
  NADIR_CHECK(rig.right.has_value() && !pair.right.empty(), pair.image);
  const CameraModel& camera = rig.right->camera;
  const Rigid3& right_from_left = rig.right->right_from_left;
  const Features right = detect_features(pair.right, camera, left.size());
  PairFit fit;
  fit.right_blank = right.size() < kMinCorners;
  std::vector<double> distances_px;
  for (const auto& [i, k] : correspond(left, right, camera).pairs) {
    ++fit.matches;
    const Eigen::Vector2d& a = left.rays[static_cast<std::size_t>(i)];
    const Eigen::Vector2d& b = right.rays[static_cast<std::size_t>(k)];
    if (const auto distance = epipolar_distance_px(*rig.right, a, b))
      distances_px.push_back(*distance);
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
