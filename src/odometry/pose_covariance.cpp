// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace nadir::odometry {
namespace {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d;
using Jacobian6 = Eigen::Matrix<double, 2, 6>;
using Jacobian3 = Eigen::Matrix<double, 2, 3>;

Matrix3d cross_matrix(const Vector3d& v) {
  return Matrix3d{{0, -v.z(), v.y()}, {v.z(), 0, -v.x()}, {-v.y(), v.x(), 0}};
}

struct Row {
  Jacobian6 by_pose;
  Jacobian3 by_point;
};

// Derivatives of the reprojection in pixels.
Row derivatives(const Adjustment& a, const CameraRig& rig, const Adjustment::Observation& o) {
  const Rigid3& pose = a.images[static_cast<std::size_t>(o.image)].camera_from_map;
  const Vector3d in_left = pose * a.points[static_cast<std::size_t>(o.point)].x_in_map;
  const CameraModel& camera = o.right ? rig.right->camera : rig.left;
  Matrix3d turn = Matrix3d::Identity();
  Vector3d x = in_left;
  if (o.right) {
    turn = rig.right->right_from_left.rotation.toRotationMatrix();
    x = rig.right->right_from_left * in_left;
  }
  const double focal = 0.5 * (camera.fx + camera.fy), inverse = 1 / x.z();
  Jacobian3 by_x;
  by_x << inverse, 0, -x.x() * inverse * inverse, 0, inverse, -x.y() * inverse * inverse;
  by_x = (focal * by_x * turn).eval();
  Row row;
  row.by_pose.leftCols<3>() = -by_x * cross_matrix(in_left);
  row.by_pose.rightCols<3>() = by_x;
  row.by_point = by_x * pose.rotation.toRotationMatrix();
  return row;
}

// Normal equations of one point and the free poses that see it.
struct PointSystem {
  Matrix3d point = Matrix3d::Zero();
  std::vector<std::pair<int, Eigen::Matrix<double, 6, 3>>> poses;  // column, cross term

  void add(int column, const Row& row, double weight) {
    point += weight * row.by_point.transpose() * row.by_point;
    if (column < 0) return;
    const Eigen::Matrix<double, 6, 3> cross = weight * row.by_pose.transpose() * row.by_point;
    const auto known =
        std::find_if(poses.begin(), poses.end(), [&](const auto& p) { return p.first == column; });
    if (known != poses.end()) {
      known->second += cross;
    } else {
      poses.emplace_back(column, cross);
    }
  }
};

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
  PoseCovariance result;
  int columns = 0;
  for (const auto& image : a.images) {
    result.column_of_.push_back(image.fixed ? -1 : 6 * columns++);
  }
  const Eigen::Index size = Eigen::Index{6} * columns;
  MatrixXd normal = MatrixXd::Zero(size, size);
  std::vector<PointSystem> points(a.points.size());
  double squares = 0, weights = 0;
  for (const auto& o : a.observations) {
    if (!std::isfinite(o.error_px)) continue;
    const double ratio = o.error_px / robust_px, weight = o.weight / (1 + ratio * ratio);
    const Row row = derivatives(a, rig, o);
    const int column = result.column_of_[static_cast<std::size_t>(o.image)];
    points[static_cast<std::size_t>(o.point)].add(column, row, weight);
    if (column >= 0) {
      normal.block<6, 6>(column, column) += weight * row.by_pose.transpose() * row.by_pose;
    }
    squares += weight * o.error_px * o.error_px;
    weights += 2 * weight;
  }
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const int column = result.column_of_[i];
    if (column < 0 || !a.images[i].distance_fixed) continue;
    // Turning the camera about its map's origin changes nothing of the distance.
    constexpr double kKnown = 1e4;  // px, of a distance of 1: far better than what is measured
    const Vector3d along = a.images[i].camera_from_map.translation.normalized();
    normal.block<3, 3>(column + 3, column + 3) += kKnown * kKnown * along * along.transpose();
  }
  int unknown = 6 * columns;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (a.points[i].fixed || points[i].poses.empty()) continue;
    const Eigen::LDLT<Matrix3d> solver(points[i].point);
    if (solver.info() != Eigen::Success || !solver.isPositive()) continue;
    unknown += 3;
    for (const auto& [first, cross] : points[i].poses) {
      const Eigen::Matrix<double, 3, 6> solved = solver.solve(cross.transpose());
      for (const auto& [second, other] : points[i].poses) {
        normal.block<6, 6>(second, first) -= other * solved;
      }
    }
  }
  if (columns == 0 || weights <= unknown) return std::nullopt;
  const Eigen::LDLT<MatrixXd> solver(normal);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const double unit = squares / (weights - unknown);
  result.covariance_ = unit * solver.solve(MatrixXd::Identity(size, size));
  if (!result.covariance_.allFinite()) return std::nullopt;
  return result;
}

PoseCovariance::Matrix6 PoseCovariance::relative(const Adjustment& a, int first, int second) const {
  const auto pose = [&](int image) -> const Rigid3& {
    return a.images[static_cast<std::size_t>(image)].camera_from_map;
  };
  const int one = column_of_[static_cast<std::size_t>(first)];
  const int other = column_of_[static_cast<std::size_t>(second)];
  // A small change of the first, seen from the second.
  const Matrix6 back = adjoint(pose(second) * pose(first).inverse());
  Matrix6 result = Matrix6::Zero();
  if (one >= 0) result += back * covariance_.block<6, 6>(one, one) * back.transpose();
  if (other >= 0) result += covariance_.block<6, 6>(other, other);
  if (one >= 0 && other >= 0) {
    const Matrix6 cross = back * covariance_.block<6, 6>(one, other);
    result -= cross + cross.transpose();
  }
  return result;
}

}  // namespace nadir::odometry
