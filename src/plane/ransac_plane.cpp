// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "ransac_plane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

namespace nadir::plane {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr std::mt19937::result_type kSeed = 20200804;
constexpr double kConfidence = 0.9999;   // that one sample was free of outliers
constexpr double kTukey = 4.685;         // 95 % efficiency on Gaussian residuals
constexpr double kNormalSigma = 1.4826;  // of a Gaussian, from its median absolute deviation

std::optional<Plane> through(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, normal = ab.cross(ac);
  if (!(normal.norm() > 1e-3 * ab.norm() * ac.norm())) return std::nullopt;  // nearly collinear
  Plane plane;
  plane.normal = normal.normalized();
  plane.centroid = a;
  plane.offset = plane.normal.dot(a);
  return plane;
}

double truncated_cost(const Plane& plane, const Points& points, double threshold) {
  double cost = 0;
  for (const Vector3d& x : points) {
    const double d = plane.normal.dot(x - plane.centroid);
    cost += std::min(d * d, threshold * threshold);
  }
  return cost;
}

int count_inliers(const Plane& plane, const Points& points, double threshold) {
  return static_cast<int>(std::ranges::count_if(points, [&](const Vector3d& x) {
    return std::abs(plane.normal.dot(x - plane.centroid)) <= threshold;
  }));
}

// Samples after which one without outliers was drawn with the wanted confidence.
int samples_needed(double inlier_ratio, int most) {
  const double miss = 1 - std::pow(inlier_ratio, 3);
  if (miss <= 0) return 1;
  if (miss >= 1) return most;
  const double needed = std::ceil(std::log(1 - kConfidence) / std::log(miss));
  return static_cast<int>(std::min(needed, static_cast<double>(most)));
}

std::optional<Plane> best_sample(const Points& points, double threshold, int max_iterations) {
  std::mt19937 random(kSeed);
  const auto draw = [&] { return points[random() % points.size()]; };
  std::optional<Plane> best;
  double least = 0;
  int needed = max_iterations, iteration = 0;
  for (; iteration < needed; ++iteration) {
    const Vector3d a = draw(), b = draw(), c = draw();
    const std::optional<Plane> candidate = through(a, b, c);
    if (!candidate) continue;
    const double cost = truncated_cost(*candidate, points, threshold);
    if (best && !(cost < least)) continue;
    best = candidate;
    least = cost;
    const double ratio =
        count_inliers(*best, points, threshold) / static_cast<double>(points.size());
    needed = samples_needed(ratio, max_iterations);
  }
  if (best) best->iterations = iteration;
  return best;
}

// The robust scale of the residuals, never so small that a perfect plane divides by zero.
double tukey_width(const Plane& plane, const Points& points, double threshold) {
  std::vector<double> residuals;
  for (const Vector3d& x : points) {
    const double d = std::abs(plane.normal.dot(x - plane.centroid));
    if (d <= threshold) residuals.push_back(d);
  }
  if (residuals.empty()) return threshold;
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::ranges::nth_element(residuals, middle);
  return std::clamp(kTukey * kNormalSigma * *middle, 0.05 * threshold, threshold);
}

// One weighted least-squares step; none when the weighted points do not span a plane.
std::optional<Plane> reweighted(const Plane& plane, const Points& points, double width) {
  double sum = 0;
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Vector3d& x : points) {
    const Vector3d from_plane = x - plane.centroid;
    const double ratio = plane.normal.dot(from_plane) / width;
    if (!(std::abs(ratio) < 1)) continue;
    const double weight = std::pow(1 - ratio * ratio, 2);
    sum += weight;
    mean += weight * from_plane;
    scatter += weight * from_plane * from_plane.transpose();
  }
  if (!(sum > 0)) return std::nullopt;
  mean /= sum;
  scatter = scatter / sum - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  // A ribbon a hundred times longer than wide, or no wider than it is thick, tilts freely.
  const Vector3d variance = axes.eigenvalues().cwiseMax(0.0);
  if (!(variance(1) > 1e-4 * variance(2)) || !(variance(1) > 2 * variance(0))) return std::nullopt;
  Plane refined = plane;
  refined.normal = axes.eigenvectors().col(0);
  refined.centroid = plane.centroid + mean;
  refined.offset = refined.normal.dot(refined.centroid);
  return refined;
}

void measure(Plane& plane, const Points& points, double threshold) {
  Vector3d sum = Vector3d::Zero();
  double squares = 0;
  plane.inliers = 0;
  for (const Vector3d& x : points) {
    const double d = plane.normal.dot(x - plane.centroid);
    if (!(std::abs(d) <= threshold)) continue;
    ++plane.inliers;
    sum += x - plane.centroid;
    squares += d * d;
  }
  if (plane.inliers == 0) return;
  plane.inlier_ratio = plane.inliers / static_cast<double>(points.size());
  plane.rms = std::sqrt(squares / plane.inliers);
  plane.centroid += sum / plane.inliers;
}

}  // namespace

std::optional<Plane> ransac_plane(const Points& points, double threshold, int max_iterations) {
  if (points.size() < 3) return std::nullopt;
  std::optional<Plane> plane = best_sample(points, threshold, max_iterations);
  constexpr int kRefinements = 10;
  for (int i = 0; plane && i < kRefinements; ++i) {
    plane = reweighted(*plane, points, tukey_width(*plane, points, threshold));
  }
  if (plane) measure(*plane, points, threshold);
  return plane;
}

}  // namespace nadir::plane
