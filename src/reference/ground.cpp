// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "ground.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace nadir::reference {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

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

}  // namespace

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

double agreement_of(double residual, double sigma) {
  const double u = residual / (4.7 * sigma);
  return std::abs(u) < 1 ? std::pow(1 - u * u, 2) : 0;
}

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

}  // namespace nadir::reference
