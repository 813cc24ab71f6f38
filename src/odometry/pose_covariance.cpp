// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "normal_equations.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d;

Eigen::Matrix<double, 6, 6> adjoint(const Rigid3& pose) {
  const Matrix3d r = pose.rotation.toRotationMatrix();
  Eigen::Matrix<double, 6, 6> result = Eigen::Matrix<double, 6, 6>::Zero();
  result.topLeftCorner<3, 3>() = r;
  result.bottomRightCorner<3, 3>() = r;
  result.bottomLeftCorner<3, 3>() = cross_matrix(pose.translation) * r;
  return result;
}

}  // namespace

std::optional<PoseCovariance> PoseCovariance::of(const Adjustment& a, const CameraRig& rig,
                                                 double robust_px) {
  Adjustment tie_points = a;  // what sensors add is little, and their unit weight is another
  tie_points.verticals.clear();
  tie_points.headings.clear();
  tie_points.heights.clear();
  tie_points.ranges.clear();
  NormalEquations equations(tie_points, rig, robust_px);
  equations.linearise(equations.start());
  double squares = 0, weights = 0;
  for (const auto& o : a.observations) {
    if (!std::isfinite(o.error_px)) continue;
    const double ratio = o.error_px / robust_px, weight = o.weight / (1 + ratio * ratio);
    squares += weight * o.error_px * o.error_px;
    weights += 2 * weight;
  }
  const MatrixXd normal = equations.reduced();
  const auto unknown =
      static_cast<double>(normal.rows() + Eigen::Index{3} * equations.eliminated());
  if (normal.rows() == 0 || weights <= unknown) return std::nullopt;
  const Eigen::LDLT<MatrixXd> solver(normal);
  constexpr double kUndetermined = 1e-12;
  const Eigen::VectorXd pivots = solver.vectorD();
  if (solver.info() != Eigen::Success || !(pivots.minCoeff() > kUndetermined * pivots.maxCoeff()))
    return std::nullopt;
  PoseCovariance result;
  for (int i = 0; i < static_cast<int>(a.images.size()); ++i) {
    result.column_of_.push_back(equations.column_of(i));
    const bool held = a.images[static_cast<std::size_t>(i)].fixed;
    if (result.column_of_.back() < 0 && !held) return std::nullopt;
  }
  const double unit = squares / (weights - unknown);
  result.covariance_ = unit * solver.solve(MatrixXd::Identity(normal.rows(), normal.rows()));
  if (!result.covariance_.allFinite()) return std::nullopt;
  return result;
}

// Sightings of one tie point are matched with the same patch and share its errors, which the
// residuals do not show: a tenth more, on rendered surveys.
Sigmas sigmas_of(const PoseCovariance::Matrix6& relative) {
  constexpr double kSharedErrors = 1.1;
  return {kSharedErrors * std::sqrt(relative.bottomRightCorner<3, 3>().trace()),
          kSharedErrors * std::sqrt(relative.topLeftCorner<3, 3>().trace())};
}

PoseCovariance::Matrix6 PoseCovariance::of_image(int image) const {
  const int column = column_of_[static_cast<std::size_t>(image)];
  return column < 0 ? Matrix6(Matrix6::Zero()) : Matrix6(covariance_.block<6, 6>(column, column));
}

PoseCovariance::Matrix6 PoseCovariance::relative(const Adjustment& a, int first, int second) const {
  const auto pose = [&](int image) -> const Rigid3& {
    return a.images[static_cast<std::size_t>(image)].camera_from_map;
  };
  const int one = column_of_[static_cast<std::size_t>(first)];
  const int other = column_of_[static_cast<std::size_t>(second)];
  // A small change of the first, seen from the second.
  const Matrix6 back = adjoint(pose(second) * pose(first).inverse());
  Matrix6 result = back * of_image(first) * back.transpose() + of_image(second);
  if (one >= 0 && other >= 0) {
    const Matrix6 cross = back * covariance_.block<6, 6>(one, other);
    result -= cross + cross.transpose();
  }
  return result;
}

}  // namespace nadir::odometry
