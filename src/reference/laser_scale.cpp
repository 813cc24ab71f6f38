// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/laser_scale.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "beam.hpp"
#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

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

// Tukey's weight: 1 for what agrees, 0 beyond 4.7 sigma.
double agreement_of(double residual, double sigma) {
  const double u = residual / (4.7 * sigma);
  return std::abs(u) < 1 ? std::pow(1 - u * u, 2) : 0;
}

// The tie points nearest to a ray, nearest first.
std::vector<Seen> nearest(const Vector2d& ray, std::vector<Seen> seen) {
  constexpr std::size_t kNeighbours = 24;
  const auto squared = [&](const Seen& point) { return (point.ray - ray).squaredNorm(); };
  const std::size_t taken = std::min(kNeighbours, seen.size());
  std::partial_sort(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(taken), seen.end(),
                    [&](const Seen& a, const Seen& b) { return squared(a) < squared(b); });
  seen.resize(taken);
  return seen;
}

// Inverse depth = plane . (1, ray - centre): the image of a plane.
struct PlaneFit {
  Vector3d plane = Vector3d::Zero();
  double leverage = 0;  ///< variance of the value at the centre, of one point of weight 1
};

PlaneFit fit_plane(const Vector2d& centre, const std::vector<Seen>& points,
                   const std::vector<double>& weights) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d from = points[i].ray - centre;
    const Vector3d row(1, from.x(), from.y());
    information += weights[i] * row * row.transpose();
    sum += weights[i] * points[i].inverse_depth * row;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(information);
  return {solver.solve(sum), solver.solve(Vector3d::UnitX()).x()};
}

// Inverse depth of the surface along a ray, in map units: of a plane through the nearest tie
// points, of which the nearer ones and those that agree count more.
std::optional<double> surface_at(const Vector2d& ray, const std::vector<Seen>& seen) {
  constexpr std::size_t kMinNeighbours = 8;
  constexpr double kFarthest = 0.25;    // of the focal length
  constexpr double kMaxLeverage = 0.5;  // a ray outside its neighbours has more
  constexpr int kIterations = 5;
  const std::vector<Seen> points = nearest(ray, seen);
  const double reach = points.empty() ? 0 : (points.back().ray - ray).norm();
  if (points.size() < kMinNeighbours || !(reach > 0 && reach < kFarthest)) return std::nullopt;

  std::vector<double> nearness, residuals(points.size());
  for (const Seen& point : points) {
    nearness.push_back(1 - (point.ray - ray).squaredNorm() / (1.2 * reach * reach));
  }
  std::vector<double> weights = nearness;
  PlaneFit fit;
  for (int i = 0; i < kIterations; ++i) {
    fit = fit_plane(ray, points, weights);
    for (std::size_t k = 0; k < points.size(); ++k) {
      residuals[k] = std::abs(fit.plane.x() + fit.plane.tail<2>().dot(points[k].ray - ray) -
                              points[k].inverse_depth);
    }
    const double sigma = std::max(1.4826 * median(residuals), 1e-9 * std::abs(fit.plane.x()));
    for (std::size_t k = 0; k < points.size(); ++k) {
      weights[k] = nearness[k] * agreement_of(residuals[k], sigma);
    }
  }
  if (!(fit.plane.x() > 0 && fit.leverage > 0 && fit.leverage < kMaxLeverage)) return std::nullopt;
  return fit.plane.x();
}

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
  return LaserEstimate{std::exp(mean.value),
                       std::hypot(mean.spread / std::sqrt(mean.independent), floor),
                       static_cast<std::uint32_t>(logs.size()), mean.spread};
}

}  // namespace nadir::reference
