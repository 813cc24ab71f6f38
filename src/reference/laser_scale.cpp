// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/laser_scale.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "beam.hpp"
#include "ground.hpp"
#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector3d;

// What no number of images takes away: the separation and how parallel the beams are, corners that
// lie higher than the ground between them; and dots measured too near to each other, by up to
// 0.2 px over a scene of gravel.
constexpr double kFloor = 0.0015;
constexpr double kFloor_px = 0.08;

// One image, before their spread is known: 0.2 px of a dot on gravel, and the relief between tie
// points. Counted as so many images.
constexpr double kUsualSpread = 0.01;
constexpr double kUsualImages = 3;

constexpr std::size_t kMinImages = 3;
constexpr std::size_t kRemembered = 4096;

// Robust mean about the median, with the spread of one value.
struct Mean {
  double value = 0, spread = 0;
  double independent = 0;  ///< how many values' worth: outliers count nothing, neighbours are alike
};

Mean robust_mean(const std::vector<double>& values) {
  constexpr int kIterations = 10;
  Mean mean;
  mean.value = median(values);
  std::vector<double> residuals;
  residuals.reserve(values.size());
  for (const double value : values) residuals.push_back(std::abs(value - mean.value));
  const double n = static_cast<double>(values.size());
  const double spread = 1.4826 * median(residuals);
  mean.spread = std::sqrt((kUsualImages * kUsualSpread * kUsualSpread + n * spread * spread) /
                          (kUsualImages + n));
  double weights = 0, squares = 0, neighbours = 0;
  for (int i = 0; i < kIterations; ++i) {
    weights = squares = neighbours = 0;
    double step = 0, before = 0;
    for (const double value : values) {
      const double weight = agreement_of(value - mean.value, mean.spread);
      const double residual = weight * (value - mean.value);
      weights += weight;
      step += residual;
      squares += residual * residual;
      neighbours += residual * before;
      before = residual;
    }
    if (weights > 0) mean.value += step / weights;
  }
  const double alike = squares > 0 ? std::clamp(neighbours / squares, 0.0, 0.9) : 0;
  mean.independent = std::max(1.0, weights * (1 - alike) / (1 + alike));
  return mean;
}

// Metres per map unit from one image.
std::optional<double> ratio_of(const LaserDots& dots, const std::array<Beam, 2>& beams,
                               double separation, const std::vector<Seen>& seen) {
  std::array<Vector3d, 2> places;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto inverse_depth = surface_at(dots.dots[i].ray, seen);
    if (!inverse_depth) return std::nullopt;
    places[i] = dots.dots[i].ray.homogeneous() / *inverse_depth;
  }
  // Along the line between the beams, so that noise beside it does not lengthen the distance.
  const double apart = across(beams).normalized().dot(places[1] - places[0]);
  return apart > 0 ? std::optional(separation / apart) : std::nullopt;
}

}  // namespace

LaserScale::LaserScale(const calibration::Lasers& lasers) : lasers_(lasers) {
  NADIR_CHECK(fault_of(lasers).empty());
}

void LaserScale::observe(const LaserDots& dots) {
  dots_[dots.image] = dots;
  if (dots_.size() > kRemembered) dots_.erase(dots_.begin());
}

void LaserScale::observe(const Window& window) {
  ground_ = Ground{window.submap, window.tie_points};
  measure(window.images);
}

void LaserScale::observe(const Orientation& orientation) {
  if (orientation.window) {
    ground_ = Ground{orientation.window->submap, orientation.window->tie_points};
  }
  measure(orientation.poses);
}

void LaserScale::measure(const std::vector<ImagePose>& poses) {
  if (!ground_) return;
  for (const ImagePose& pose : poses) {
    const auto dots = dots_.find(pose.image);
    if (pose.submap != ground_->submap || dots == dots_.end()) continue;
    const auto seen = seen_by(pose, ground_->tie_points);
    const auto ratio = ratio_of(dots->second, beams_of(lasers_), lasers_.separation, seen);
    if (!ratio) continue;
    const auto& [first, second] = dots->second.dots;
    measures_[pose.submap][pose.image] = {std::log(*ratio), (second.pixel - first.pixel).norm()};
  }
}

void LaserScale::resized(std::uint32_t submap, double factor) {
  NADIR_CHECK(factor > 0, factor);
  if (ground_ && ground_->submap == submap) ground_.reset();  // lies where the map was
  const auto measures = measures_.find(submap);
  if (measures == measures_.end()) return;
  for (auto& [image, measure] : measures->second) measure.log_ratio -= std::log(factor);
}

std::optional<LaserEstimate> LaserScale::estimate(std::uint32_t submap) const {
  const auto measures = measures_.find(submap);
  if (measures == measures_.end() || measures->second.size() < kMinImages) return std::nullopt;
  std::vector<double> logs, apart_px;
  for (const auto& [image, measure] : measures->second) {
    logs.push_back(measure.log_ratio);
    apart_px.push_back(measure.apart_px);
  }
  const Mean mean = robust_mean(logs);
  const double floor = std::hypot(kFloor, kFloor_px / median(std::move(apart_px)));
  return LaserEstimate{
      {std::exp(mean.value), std::hypot(mean.spread / std::sqrt(mean.independent), floor),
       static_cast<std::uint32_t>(logs.size())},
      mean.spread};
}

}  // namespace nadir::reference
