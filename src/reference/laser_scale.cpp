// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/laser_scale.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "beam.hpp"
#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// What no number of images takes away: the separation and how parallel the beams are (0.1 %), a
// spot's centre where the light falls unevenly (0.02 px of 27), and corners that lie higher than
// the ground between them (0.1 %).
constexpr double kFloor = 0.002;

// One image, before their spread is known: 0.2 px of a dot on gravel, and the relief between tie
// points. Counted as so many images.
constexpr double kUsualSpread = 0.01;
constexpr double kUsualImages = 3;

constexpr std::size_t kMinImages = 3;
constexpr std::size_t kRemembered = 4096;

// A tie point as an image sees it.
struct Seen {
  Vector2d ray;
  double inverse_depth = 0;  ///< per map unit
};

std::vector<Seen> seen_by(const ImagePose& pose, const std::vector<TiePoint>& tie_points) {
  const Rigid3 camera_from_map = pose.survey_from_camera.inverse();
  std::vector<Seen> seen;
  seen.reserve(tie_points.size());
  for (const TiePoint& point : tie_points) {
    const Vector3d x = camera_from_map * point.x_in_survey;
    if (x.z() > 0 && x.allFinite()) seen.push_back({x.head<2>() / x.z(), 1 / x.z()});
  }
  return seen;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Inverse depth of the surface along a ray, in map units: on a plane it is linear in the ray, so a
// plane is fitted to the nearest tie points, with the nearer ones and those that agree counting
// more.
std::optional<double> surface_at(const Vector2d& ray, std::vector<Seen> seen) {
  constexpr std::size_t kNeighbours = 24, kMinNeighbours = 8;
  constexpr double kFarthest = 0.25;    // of the focal length
  constexpr double kMaxLeverage = 0.5;  // of all neighbours' weight: a ray outside them has more
  constexpr int kIterations = 5;
  if (seen.size() < kMinNeighbours) return std::nullopt;
  const auto distance = [&](const Seen& point) { return (point.ray - ray).norm(); };
  const std::size_t taken = std::min(kNeighbours, seen.size());
  std::partial_sort(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(taken), seen.end(),
                    [&](const Seen& a, const Seen& b) { return distance(a) < distance(b); });
  seen.resize(taken);
  const double reach = distance(seen.back());
  if (!(reach > 0 && reach < kFarthest)) return std::nullopt;

  std::vector<double> agreement(taken, 1.0), residuals(taken);
  Vector3d plane = Vector3d::Zero();
  double leverage = 0;
  for (int i = 0; i < kIterations; ++i) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < taken; ++k) {
      const Vector3d row(1, seen[k].ray.x() - ray.x(), seen[k].ray.y() - ray.y());
      const double nearness = 1 - std::pow(distance(seen[k]) / (1.1 * reach), 2);
      const double weight = agreement[k] * nearness;
      information += weight * row * row.transpose();
      sum += weight * seen[k].inverse_depth * row;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(information);
    plane = solver.solve(sum);
    leverage = solver.solve(Vector3d::UnitX()).x();
    for (std::size_t k = 0; k < taken; ++k) {
      residuals[k] =
          std::abs(plane.x() + plane.tail<2>().dot(seen[k].ray - ray) - seen[k].inverse_depth);
    }
    const double scale = std::max(1.4826 * median(residuals), 1e-9 * std::abs(plane.x()));
    for (std::size_t k = 0; k < taken; ++k) {
      const double u = residuals[k] / (4.7 * scale);  // Tukey
      agreement[k] = u < 1 ? std::pow(1 - u * u, 2) : 0;
    }
  }
  if (!(plane.x() > 0 && leverage > 0 && leverage < kMaxLeverage)) return std::nullopt;
  return plane.x();
}

// Huber's mean of values about their median, with the spread of those it trusts.
struct Mean {
  double value = 0, spread = 0;
  double independent = 0;  ///< how many values' worth, neighbours being alike
};

Mean robust_mean(const std::vector<double>& values) {
  constexpr double kHuber = 1.5;
  constexpr int kIterations = 10;
  Mean mean;
  mean.value = median(values);
  std::vector<double> residuals;
  for (const double value : values) residuals.push_back(std::abs(value - mean.value));
  const double n = static_cast<double>(values.size());
  const double spread = 1.4826 * median(residuals);
  mean.spread = std::sqrt((kUsualImages * kUsualSpread * kUsualSpread + n * spread * spread) /
                          (kUsualImages + n));
  const double limit = kHuber * mean.spread;
  for (int i = 0; i < kIterations; ++i) {
    double step = 0;
    for (const double value : values) step += std::clamp(value - mean.value, -limit, limit);
    mean.value += step / n;
  }
  double squares = 0, neighbours = 0, before = 0;
  for (const double value : values) {
    const double residual = std::clamp(value - mean.value, -2 * limit, 2 * limit);
    squares += residual * residual;
    neighbours += residual * before;
    before = residual;
  }
  const double alike = squares > 0 ? std::clamp(neighbours / squares, 0.0, 0.9) : 0;
  mean.independent = std::max(1.0, n * (1 - alike) / (1 + alike));
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
    if (ratio) measures_[pose.submap][pose.image] = std::log(*ratio);
  }
}

void LaserScale::resized(std::uint32_t submap, double factor) {
  NADIR_CHECK(factor > 0, factor);
  if (ground_ && ground_->submap == submap) ground_.reset();  // lies where the map was
  const auto measures = measures_.find(submap);
  if (measures == measures_.end()) return;
  for (auto& [image, log_ratio] : measures->second) log_ratio -= std::log(factor);
}

std::optional<LaserEstimate> LaserScale::estimate(std::uint32_t submap) const {
  const auto measures = measures_.find(submap);
  if (measures == measures_.end() || measures->second.size() < kMinImages) return std::nullopt;
  std::vector<double> logs;
  for (const auto& [image, log_ratio] : measures->second) logs.push_back(log_ratio);
  const Mean mean = robust_mean(logs);
  return LaserEstimate{std::exp(mean.value),
                       std::hypot(mean.spread / std::sqrt(mean.independent), kFloor),
                       static_cast<std::uint32_t>(logs.size()), mean.spread};
}

}  // namespace nadir::reference
