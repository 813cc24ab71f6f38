// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/self_calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "calibration_bundle.hpp"

namespace nadir::odometry {
namespace {

using Eigen::MatrixXd, Eigen::Vector2d, Eigen::VectorXd;

constexpr std::size_t kFewestKeyFrames = 5;

// Places all over the image.
std::vector<Vector2d> grid(const CameraModel& camera) {
  constexpr int kCells = 16;
  std::vector<Vector2d> places;
  for (int row = 0; row <= kCells; ++row) {
    for (int column = 0; column <= kCells; ++column) {
      places.emplace_back(column * (camera.width - 1.) / kCells,
                          row * (camera.height - 1.) / kCells);
    }
  }
  return places;
}

// From where the given lens has a ray to where the other has it; a shift, a turn and a zoom apart.
std::vector<Vector2d> displacements(const CameraModel& given, const CameraModel& other) {
  std::vector<Vector2d> from, moved;
  for (const Vector2d& pixel : grid(given)) {
    const auto ray = given.unproject(pixel);
    const auto to = ray ? other.project(ray->homogeneous()) : std::nullopt;
    if (!to) continue;
    from.push_back(pixel - Vector2d(given.cx, given.cy));
    moved.push_back(*to - pixel);
  }
  MatrixXd by(2 * static_cast<Eigen::Index>(from.size()), 4);
  VectorXd all(by.rows());
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    by.row(row) << 1, 0, from[i].x(), -from[i].y();
    by.row(row + 1) << 0, 1, from[i].y(), from[i].x();
    all.segment<2>(row) = moved[i];
  }
  if (from.size() < 4) return {};
  all -= by * by.colPivHouseholderQr().solve(all);
  for (std::size_t i = 0; i < from.size(); ++i) {
    moved[i] = all.segment<2>(2 * static_cast<Eigen::Index>(i));
  }
  return moved;
}

// The largest displacement, and what the lens's own uncertainty makes of that place.
Estimate distortion_of(const CameraModel& given, const CameraModel& refined,
                       const MatrixXd& covariance) {
  const std::vector<Vector2d> moved = displacements(given, refined);
  if (moved.empty()) return {};
  const auto farthest = std::ranges::max_element(
      moved, {}, [](const Vector2d& displacement) { return displacement.norm(); });
  const auto place = static_cast<std::size_t>(farthest - moved.begin());
  Estimate estimate{farthest->norm(), 0};
  // In small steps: the whole sigma of a lens hardly known leaves its valid field.
  constexpr double kStep = 1e-3;
  const Eigen::LLT<MatrixXd> factors(covariance);
  if (factors.info() != Eigen::Success) return {estimate.value, INFINITY};
  const MatrixXd root = kStep * MatrixXd(factors.matrixL());
  for (Eigen::Index k = 0; k < root.cols(); ++k) {
    Lens other = to_parameters(refined);
    for (std::size_t i = 0; i < other.size(); ++i) {
      other[i] += root(static_cast<Eigen::Index>(i), k);
    }
    const std::vector<Vector2d> changed = displacements(given, with(refined, other));
    if (changed.size() != moved.size()) return {estimate.value, INFINITY};
    estimate.sigma += ((changed[place] - *farthest) / kStep).squaredNorm();
  }
  estimate.sigma = std::sqrt(estimate.sigma);
  return estimate;
}

LensFit fit_of(const CameraModel& given, const CameraModel& refined, const MatrixXd& covariance) {
  LensFit fit;
  fit.refined = refined;
  fit.focal_ratio.value = 0.5 * (refined.fx / given.fx + refined.fy / given.fy);
  const double variance = 0.25 * (covariance(0, 0) + 2 * covariance(0, 1) + covariance(1, 1));
  fit.focal_ratio.sigma = std::sqrt(variance) / given.fx;
  fit.distortion_px = distortion_of(given, refined, covariance);
  return fit;
}

struct Rms {
  double squares = 0, weights = 0;
  void add(double px) {
    const double ratio = px / kRobust_px, weight = 1 / (1 + ratio * ratio);
    squares += weight * px * px;
    weights += weight;
  }
  double value() const { return weights > 0 ? std::sqrt(squares / weights) : 0; }
};

double rms_of(const std::vector<CalibrationBundle::Error>& errors) {
  Rms rms;
  for (const CalibrationBundle::Error& error : errors) rms.add(error.px);
  return rms.value();
}

std::array<double, 4> by_ring(const std::vector<CalibrationBundle::Error>& errors, bool right) {
  std::array<Rms, 4> rings;
  for (const CalibrationBundle::Error& error : errors) {
    if (error.right == right)
      rings[std::min<std::size_t>(3, std::size_t(4 * error.ring))].add(error.px);
  }
  std::array<double, 4> values{};
  std::ranges::transform(rings, values.begin(), &Rms::value);
  return values;
}

}  // namespace

std::optional<CalibrationFit> fit_calibration(
    const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames) {
  if (key_frames.size() < kFewestKeyFrames) return std::nullopt;
  CalibrationBundle bundle(key_frames);
  if (!bundle.rich() || !bundle.solve(false)) return std::nullopt;
  CalibrationFit fit;
  fit.images = static_cast<int>(bundle.images());
  fit.observations = bundle.observations();
  const std::vector<CalibrationBundle::Error> errors = bundle.errors();
  fit.rms_px = rms_of(errors);
  const double epipolar_px = bundle.has_pair() ? bundle.epipolar_px() : 0;

  if (!bundle.solve(true)) return std::nullopt;
  const auto covariance = bundle.covariance();
  if (!covariance) return std::nullopt;
  fit.refined_rms_px = rms_of(bundle.errors());
  const CameraRig refined = bundle.refined();
  fit.left = fit_of(bundle.given().left, refined.left, covariance->left);
  fit.left.rms_px = by_ring(errors, false);
  if (bundle.has_pair()) {
    fit.right = fit_of(bundle.given().right->camera, refined.right->camera, covariance->right);
    fit.right->rms_px = by_ring(errors, true);
    fit.pair = PairFit{
        epipolar_px, bundle.epipolar_px(), {bundle.delay_s(), std::sqrt(covariance->delay_s2)}};
  }
  return fit;
}

}  // namespace nadir::odometry
