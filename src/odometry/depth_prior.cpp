// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/depth_prior.hpp"
#include "median.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace nadir::odometry {
namespace {

constexpr std::size_t kMinSamples = 8;
constexpr double kMinSpread = 0.08;  // of the inverse depth
constexpr double kNear = 0.05;       // normalised coordinates: relief alike
constexpr double kFar = 0.20;        // normalised coordinates: relief unrelated
constexpr double kMaxSpread = 0.5;

// Iteratively reweighted least squares; three unknowns.
Eigen::Vector3d fit_plane(const std::vector<DepthSample>& samples) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const auto& s : samples) values.push_back(s.inverse_depth);
  Eigen::Vector3d plane(0, 0, median(values));
  for (int i = 0; i < 6; ++i) {
    std::vector<double> residuals;
    residuals.reserve(samples.size());
    for (const auto& s : samples) {
      residuals.push_back(std::abs(s.inverse_depth - plane.dot(s.ray.homogeneous())));
    }
    const double scale = std::max(1.5 * median(residuals), 1e-3 * std::abs(plane.z()));
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const double ratio = residuals[k] / scale, weight = 1 / (1 + ratio * ratio);
      const Eigen::Vector3d row = samples[k].ray.homogeneous();
      normal += weight * row * row.transpose();
      right += weight * samples[k].inverse_depth * row;
    }
    plane = normal.ldlt().solve(right);
  }
  return plane;
}

}  // namespace

DepthPrior::DepthPrior(std::vector<DepthSample> samples) : samples_(std::move(samples)) {
  std::erase_if(samples_, [](const DepthSample& s) {
    return !(s.inverse_depth > 0) || !std::isfinite(s.inverse_depth);
  });
  if (samples_.size() < kMinSamples) return;
  plane_ = fit_plane(samples_);
  known_ = plane_.allFinite() && plane_.z() > 0;
  std::vector<double> residuals;
  residuals.reserve(samples_.size());
  for (auto& s : samples_) {
    s.inverse_depth -= plane_.dot(s.ray.homogeneous());
    residuals.push_back(std::abs(s.inverse_depth));
  }
  relief_ = 4.5 * median(std::move(residuals));  // three times a robust standard deviation
  std::sort(samples_.begin(), samples_.end(),
            [](const DepthSample& a, const DepthSample& b) { return a.ray.x() < b.ray.x(); });
}

// Outwards along x from the ray, until what comes next is farther in x alone.
std::array<DepthPrior::Neighbour, DepthPrior::kNeighbours> DepthPrior::nearest(
    const Eigen::Vector2d& ray) const {
  std::array<Neighbour, kNeighbours> near;
  const auto consider = [&](const DepthSample& s) {
    const double across = s.ray.x() - ray.x();
    if (!(across * across < near.back().squared_distance)) return false;
    const double distance = (s.ray - ray).squaredNorm();
    if (distance >= near.back().squared_distance) return true;
    near.back() = {distance, s.inverse_depth};
    for (std::size_t i = kNeighbours - 1;
         i > 0 && near[i].squared_distance < near[i - 1].squared_distance; --i) {
      std::swap(near[i], near[i - 1]);
    }
    return true;
  };
  auto right = std::ranges::lower_bound(samples_, ray.x(), {},
                                        [](const DepthSample& s) { return s.ray.x(); });
  auto left = std::make_reverse_iterator(right);
  bool more_right = true, more_left = true;
  while (more_right || more_left) {
    more_right = more_right && right != samples_.end() && consider(*right++);
    more_left = more_left && left != samples_.rend() && consider(*left++);
  }
  return near;
}

DepthPrior::Guess DepthPrior::at(const Eigen::Vector2d& ray) const {
  if (!known_) return {};
  const auto near = nearest(ray);
  std::array<double, kNeighbours> residuals;
  std::transform(near.begin(), near.end(), residuals.begin(),
                 [](const Neighbour& n) { return n.residual; });
  std::sort(residuals.begin(), residuals.end());
  const double local = 0.5 * (residuals[2] + residuals[3]);
  const double on_plane = std::max(plane_.dot(ray.homogeneous()), 0.2 * plane_.z());
  const double guess = std::clamp(on_plane + local, 0.3 * on_plane, 3 * on_plane);
  const double local_spread = 2 * (residuals[4] - residuals[1]);
  const double distance = std::sqrt(near[2].squared_distance);
  const double strange = std::clamp((distance - kNear) / (kFar - kNear), 0.0, 1.0);
  const double spread = std::max(local_spread, strange * (relief_ + kMinSpread * guess));
  return {guess, std::clamp(spread, kMinSpread * guess, kMaxSpread * guess)};
}

Eigen::Vector3d DepthPrior::normal() const {
  return known_ ? Eigen::Vector3d(plane_.normalized()) : Eigen::Vector3d(0, 0, 1);
}

}  // namespace nadir::odometry
