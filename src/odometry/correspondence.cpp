// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/correspondence.hpp"

#include <algorithm>
#include <cmath>

#include "matching.hpp"
#include "relative_orientation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kRatio = 0.85;

}  // namespace

double corner_sigma(const CameraModel& camera) { return 0.6 / camera.mean_focal(); }

Correspondences correspond(const Features& first, const Features& second,
                           const CameraModel& camera) {
  constexpr int kFew = 60;
  const double sigma = corner_sigma(camera);
  Correspondences result;
  const auto verified = [&](const Pairs& pairs, Eigen::Matrix3d& homography) {
    Rays a, b;
    for (const auto& [i, k] : pairs) {
      a.push_back(first.rays[static_cast<std::size_t>(i)]);
      b.push_back(second.rays[static_cast<std::size_t>(k)]);
    }
    const Agreement agreement = verify(a, b, sigma);
    homography = agreement.homography;
    Pairs kept;
    for (const int i : agreement.inliers) kept.push_back(pairs[static_cast<std::size_t>(i)]);
    return kept;
  };
  Eigen::Matrix3d homography;
  result.pairs =
      verified(match_descriptors(first.descriptors, second.descriptors, kRatio), homography);
  const bool guided = is_binary(first.descriptors) && !homography.isZero();
  if (static_cast<int>(result.pairs.size()) < kFew && guided) {
    std::vector<Vector2d> places;
    for (const auto& ray : first.rays) {
      const Vector3d h = homography * ray.homogeneous();
      const auto pixel = camera.project(h.z() > 0 ? h : Vector3d(-h));
      places.push_back(pixel.value_or(Vector2d::Constant(std::nan(""))));
    }
    auto more = verified(match_near(first.descriptors, places, second, 0.03 * camera.width, 70),
                         homography);
    if (more.size() > result.pairs.size()) result.pairs = std::move(more);
  }
  std::vector<double> shifts;
  for (const auto& [i, k] : result.pairs) {
    shifts.push_back(
        (first.pixels[static_cast<std::size_t>(i)] - second.pixels[static_cast<std::size_t>(k)])
            .norm());
  }
  if (!shifts.empty()) {
    const auto middle = shifts.begin() + static_cast<std::ptrdiff_t>(shifts.size() / 2);
    std::nth_element(shifts.begin(), middle, shifts.end());
    result.shift_px = *middle;
  }
  return result;
}

int likeness(const Features& first, const Features& second) {
  static constexpr int kStrongest = 300;
  constexpr double kStrictRatio = 0.75;
  const auto strongest = [](const Features& features) {
    return features.descriptors.rowRange(0, std::min(kStrongest, features.size()));
  };
  if (first.size() < 2 || second.size() < 2) return 0;
  return static_cast<int>(
      match_descriptors(strongest(first), strongest(second), kStrictRatio).size());
}

}  // namespace nadir::odometry
