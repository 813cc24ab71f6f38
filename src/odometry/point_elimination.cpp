// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Elimination of the tie points, and what follows from it: a step, or the poses' own equations.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>

#include "nadir/core/check.hpp"
#include "nadir/core/clones.hpp"
#include "normal_equations.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d,
    Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// What keeps directions that nothing determines from being solved for, px2.
constexpr double kFloor = 1e-9;

Eigen::Quaterniond turn(const Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector / angle));
}

// Of a point's normal matrix; along a ray that no other meets it says nothing, and is zero there.
Matrix3d inverse_of(const Matrix3d& normal) {
  constexpr double kFlat = 1e-12;  // least certainty over greatest
  const Eigen::LLT<Matrix3d> solver(normal);
  const Vector3d pivots = solver.matrixLLT().diagonal().cwiseAbs2();
  if (solver.info() == Eigen::Success && pivots.minCoeff() > kFlat * pivots.maxCoeff()) {
    return solver.solve(Matrix3d::Identity());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(normal);
  Vector3d inverse = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double certainty = axes.eigenvalues()[i];
    if (certainty > kFlat * axes.eigenvalues()[2]) inverse[i] = 1 / certainty;
  }
  return axes.eigenvectors() * inverse.asDiagonal() * axes.eigenvectors().transpose();
}

}  // namespace

NADIR_CLONES
NormalEquations::Reduced NormalEquations::reduce(double damping) const {
  Reduced result{blocks_, gradient_, std::vector<Matrix3d>(points_.size(), Matrix3d::Zero())};
  for (int pose = 0; pose < poses_; ++pose) {
    auto diagonal = result.blocks[static_cast<std::size_t>(pose)].diagonal();
    diagonal += damping * (diagonal + Vector6::Constant(kFloor));
  }
  for (const auto& [pose, block] : held_) {
    result.blocks[static_cast<std::size_t>(pose)].bottomRightCorner<3, 3>() += block;
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    if (!point.free) continue;
    Matrix3d normal = point.normal;
    normal.diagonal() *= 1 + damping;
    const Matrix3d inverse = inverse_of(normal);
    result.inverse[i] = inverse;
    std::size_t pair = point.first_slot;
    for (int k = point.first_cell; k < point.end_cell; ++k) {
      const Cell& first = cells_[static_cast<std::size_t>(k)];
      const Matrix63 solved = first.cross * inverse;
      result.gradient.segment<6>(row_of(first.pose)).noalias() -= solved * point.gradient;
      for (int m = k; m < point.end_cell; ++m) {
        const Cell& second = cells_[static_cast<std::size_t>(m)];
        result.blocks[static_cast<std::size_t>(slots_[pair++])].noalias() -=
            solved * second.cross.transpose();
      }
    }
  }
  return result;
}

std::optional<VectorXd> NormalEquations::solve(const Reduced& reduced, double damping) const {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * reduced.blocks.size() + static_cast<std::size_t>(12 * poses_ + 4));
  const auto add = [&](int row, int column, const auto& block) {
    for (int c = 0; c < block.cols(); ++c) {
      for (int r = 0; r < block.rows() && row + r <= column + c; ++r) {
        entries.emplace_back(row + r, column + c, block(r, c));
      }
    }
  };
  for (std::size_t i = 0; i < reduced.blocks.size(); ++i) {
    add(6 * block_poses_[i].first, 6 * block_poses_[i].second, reduced.blocks[i]);
  }
  if (is_up_free()) {
    for (int pose = 0; pose < poses_; ++pose) {
      add(6 * pose, 6 * poses_, by_up_[static_cast<std::size_t>(pose)]);
    }
    Matrix2d up = up_normal_;
    up.diagonal() *= 1 + damping;
    add(6 * poses_, 6 * poses_, up);
  }
  Eigen::SparseMatrix<double> matrix(unknowns(), unknowns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Upper> solver(matrix);
  if (solver.info() != Eigen::Success) return std::nullopt;
  VectorXd solution = solver.solve(reduced.gradient);
  if (!solution.allFinite()) return std::nullopt;
  return solution;
}

std::optional<NormalEquations::Step> NormalEquations::step(const Unknowns& from,
                                                           double damping) const {
  const Reduced reduced = reduce(damping);
  VectorXd poses(0);
  if (unknowns() > 0) {
    const auto solution = solve(reduced, damping);
    if (!solution) return std::nullopt;
    poses = *solution;
  }
  // Where x solves (H + damping D) x = g, the cost falls by x g - x H x / 2 = (x g + damping x D x)
  // / 2.
  double expected = poses.dot(gradient_);
  for (int pose = 0; pose < poses_; ++pose) {
    const Vector6 x = poses.segment<6>(row_of(pose));
    const auto diagonal = blocks_[static_cast<std::size_t>(pose)].diagonal();
    expected += damping * x.dot(diagonal.cwiseProduct(x));
  }
  if (is_up_free()) {
    const Vector2d x = poses.tail<2>();
    expected += damping * x.dot(up_normal_.diagonal().cwiseProduct(x));
  }
  std::vector<Vector3d> points(points_.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    if (!point.free) continue;
    Vector3d rest = point.gradient;
    for (int k = point.first_cell; k < point.end_cell; ++k) {
      const Cell& cell = cells_[static_cast<std::size_t>(k)];
      rest.noalias() -= cell.cross.transpose() * poses.segment<6>(row_of(cell.pose));
    }
    points[i] = reduced.inverse[i] * rest;
    const Vector3d damped = point.normal.diagonal().cwiseProduct(points[i]);
    expected += points[i].dot(point.gradient) + damping * points[i].dot(damped);
  }
  return Step{moved(from, poses, points), expected / 2};
}

Unknowns NormalEquations::moved(const Unknowns& from, const VectorXd& poses,
                                const std::vector<Vector3d>& points) const {
  Unknowns there = from;
  for (std::size_t i = 0; i < pose_of_.size(); ++i) {
    if (pose_of_[i] < 0) continue;
    const Vector6 x = poses.segment<6>(row_of(pose_of_[i]));
    Rigid3& pose = there.camera_from_map[i];
    const double distance = pose.translation.norm();
    pose = Rigid3{turn(x.head<3>()), x.tail<3>()} * pose;
    if (a_.images[i].distance_fixed) pose.translation *= distance / pose.translation.norm();
  }
  for (std::size_t i = 0; i < points.size(); ++i) there.points[i] += points[i];
  if (is_up_free()) there.up = (there.up + up_tangent_ * poses.tail<2>()).normalized();
  return there;
}

MatrixXd NormalEquations::reduced() const {
  NADIR_CHECK(!is_up_free());
  const Reduced result = reduce(0);
  MatrixXd matrix = MatrixXd::Zero(unknowns(), unknowns());
  for (std::size_t i = 0; i < result.blocks.size(); ++i) {
    matrix.block<6, 6>(row_of(block_poses_[i].first), row_of(block_poses_[i].second)) =
        result.blocks[i];
  }
  matrix.triangularView<Eigen::StrictlyLower>() = matrix.transpose();
  return matrix;
}

int NormalEquations::column_of(int image) const {
  const int pose = pose_of_[static_cast<std::size_t>(image)];
  return pose < 0 ? -1 : 6 * pose;
}

int NormalEquations::eliminated() const {
  return static_cast<int>(std::count_if(points_.begin(), points_.end(),
                                        [](const Point& p) { return p.free && p.seen; }));
}

}  // namespace nadir::odometry
