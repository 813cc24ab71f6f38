// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "normal_equations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>

#include "nadir/core/check.hpp"
#include "nadir/core/clones.hpp"
#include "sensor_errors.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d,
    Eigen::VectorXd;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kNearest = 1e-6;  // in front of a camera

// Of a held distance, pixels per map unit: tie points of a camera one unit away hold it to a tenth.
constexpr double kKnown = 1e4;

// What keeps directions that nothing determines from being solved for, px2.
constexpr double kFloor = 1e-9;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Matrix3d cross_matrix(const Vector3d& v) {
  return Matrix3d{{0, -v.z(), v.y()}, {v.z(), 0, -v.x()}, {-v.y(), v.x(), 0}};
}

double mean_focal(const CameraModel& camera) { return 0.5 * (camera.fx + camera.fy); }

// Where the search for the map's vertical starts.
Vector3d up_of(const Adjustment& a) {
  if (a.up_in_map) return *a.up_in_map;
  if (a.verticals.empty()) return Vector3d::UnitZ();
  const auto& first = a.verticals.front();
  const Rigid3& pose = a.images[static_cast<std::size_t>(first.image)].camera_from_map;
  return pose.rotation.conjugate() * first.up_in_camera;
}

// Two directions across a unit vector.
Eigen::Matrix<double, 3, 2> tangent(const Vector3d& unit) {
  Eigen::Matrix<double, 3, 2> result;
  result.col(0) = unit.unitOrthogonal();
  result.col(1) = unit.cross(result.col(0));
  return result;
}

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

Vector3d vertical_error(const Adjustment::Vertical& v, const Vector3d& up_in_camera) {
  return (kTypical_px / v.sigma) * (up_in_camera - v.up_in_camera);
}

}  // namespace

bool Unknowns::is_finite() const {
  const auto finite = [](const auto& x) { return x.allFinite(); };
  return finite(up) && std::all_of(points.begin(), points.end(), finite) &&
         std::all_of(camera_from_map.begin(), camera_from_map.end(),
                     [](const Rigid3& pose) { return pose.is_finite(); });
}

NormalEquations::NormalEquations(const Adjustment& adjustment, const CameraRig& rig,
                                 double robust_px)
    : a_(adjustment), robust_px_(robust_px) {
  right_from_left_ = {Matrix3d::Identity(), Vector3d::Zero()};
  focal_ = {mean_focal(rig.left), mean_focal(rig.left)};
  if (rig.right) {
    right_from_left_ = {rig.right->right_from_left.rotation.toRotationMatrix(),
                        rig.right->right_from_left.translation};
    focal_[1] = mean_focal(rig.right->camera);
  }
  points_.resize(a_.points.size());
  for (std::size_t i = 0; i < points_.size(); ++i) points_[i].free = !a_.points[i].fixed;
  add_structure();
}

void NormalEquations::add_structure() {
  const Unknowns at = start();
  const auto left = left_cameras(at), right = right_cameras(left);
  seen_.reserve(a_.observations.size());
  for (const auto& o : a_.observations) {
    const Camera& camera = (o.right ? right : left)[static_cast<std::size_t>(o.image)];
    const Vector3d x = camera.rotation * at.points[static_cast<std::size_t>(o.point)];
    const double depth = x.z() + camera.translation.z();
    if (!(depth > kNearest) || !std::isfinite(depth) || !o.ray.allFinite()) continue;
    seen_.push_back({o.image, o.point, -1, o.right, o.ray, o.weight});
  }
  const auto earlier = [](const Seen& a, const Seen& b) {
    return std::tie(a.point, a.image) < std::tie(b.point, b.image);
  };
  if (!std::is_sorted(seen_.begin(), seen_.end(), earlier))
    std::stable_sort(seen_.begin(), seen_.end(), earlier);
  number_poses();
  std::unordered_map<std::uint64_t, int> slots;  // of the block of two poses
  const auto slot = [&](int first, int second) {
    const auto key = (static_cast<std::uint64_t>(first) << 32) | static_cast<std::uint32_t>(second);
    const auto [known, is_new] = slots.try_emplace(key, static_cast<int>(block_poses_.size()));
    if (is_new) block_poses_.emplace_back(first, second);
    return known->second;
  };
  for (int pose = 0; pose < poses_; ++pose) slot(pose, pose);
  for (auto s = seen_.begin(); s != seen_.end();) {
    Point& point = points_[static_cast<std::size_t>(s->point)];
    point.seen = true;
    point.first_cell = static_cast<int>(cells_.size());
    for (const int index = s->point; s != seen_.end() && s->point == index; ++s) {
      const int pose = pose_of_[static_cast<std::size_t>(s->image)];
      if (!point.free || pose < 0) continue;
      const bool first = point.first_cell == static_cast<int>(cells_.size());
      if (first || cells_.back().pose != pose) cells_.push_back({pose, Matrix63::Zero()});
      s->cell = static_cast<int>(cells_.size()) - 1;
    }
    point.end_cell = static_cast<int>(cells_.size());
    point.first_slot = slots_.size();
    for (int i = point.first_cell; i < point.end_cell; ++i) {
      for (int k = i; k < point.end_cell; ++k) {
        slots_.push_back(slot(cells_[static_cast<std::size_t>(i)].pose,
                              cells_[static_cast<std::size_t>(k)].pose));
      }
    }
  }
}

// An image in which nothing is seen stays where it is.
void NormalEquations::number_poses() {
  std::vector<char> sees(a_.images.size(), 0);
  for (const Seen& s : seen_) sees[static_cast<std::size_t>(s.image)] = 1;
  for (std::size_t i = 0; i < a_.images.size(); ++i) {
    pose_of_.push_back(a_.images[i].fixed || sees[i] == 0 ? -1 : poses_++);
  }
}

Unknowns NormalEquations::start() const {
  Unknowns at;
  for (const auto& image : a_.images) at.camera_from_map.push_back(image.camera_from_map);
  for (const auto& point : a_.points) at.points.push_back(point.x_in_map);
  at.up = up_of(a_);
  return at;
}

std::vector<NormalEquations::Camera> NormalEquations::left_cameras(const Unknowns& at) const {
  std::vector<Camera> cameras;
  cameras.reserve(at.camera_from_map.size());
  for (const Rigid3& pose : at.camera_from_map) {
    cameras.push_back({pose.rotation.toRotationMatrix(), pose.translation});
  }
  return cameras;
}

std::vector<NormalEquations::Camera> NormalEquations::right_cameras(
    const std::vector<Camera>& left) const {
  std::vector<Camera> cameras;
  cameras.reserve(left.size());
  for (const Camera& c : left) {
    const auto& r = right_from_left_;
    cameras.push_back({r.rotation * c.rotation, r.rotation * c.translation + r.translation});
  }
  return cameras;
}

double NormalEquations::robust(double squares) const {
  const double unit = robust_px_ * robust_px_;
  return unit * std::log1p(squares / unit);
}

double NormalEquations::cost(const Unknowns& at) const {
  const auto left = left_cameras(at), right = right_cameras(left);
  double sum = 0;
  for (const Seen& s : seen_) {
    const Camera& camera = (s.right ? right : left)[static_cast<std::size_t>(s.image)];
    const Vector3d x =
        camera.rotation * at.points[static_cast<std::size_t>(s.point)] + camera.translation;
    if (!(x.z() > kNearest)) return kInfinity;
    const Vector2d error = focal_[s.right ? 1 : 0] * (x.head<2>() / x.z() - s.ray);
    sum += s.weight * robust(error.squaredNorm());
  }
  for (const auto& v : a_.verticals) {
    const Vector3d up = left[static_cast<std::size_t>(v.image)].rotation * at.up;
    sum += robust(vertical_error(v, up).squaredNorm());
  }
  for_each_sensor(at, [&](int, int, const SensorError& e) { sum += robust(e.px * e.px); });
  return sum / 2;
}

void NormalEquations::linearise(const Unknowns& at) {
  blocks_.assign(block_poses_.size(), Matrix6::Zero());
  gradient_ = VectorXd::Zero(unknowns());
  for (Point& point : points_) point.normal.setZero(), point.gradient.setZero();
  for (Cell& cell : cells_) cell.cross.setZero();
  add_observations(at);
  hold_distances(at);
  add_verticals(at);
  add_sensors(at);
}

NADIR_CLONES
void NormalEquations::add_observations(const Unknowns& at) {
  const auto left = left_cameras(at);
  const double unit = robust_px_ * robust_px_;
  for (const Seen& s : seen_) {
    const Camera& camera = left[static_cast<std::size_t>(s.image)];
    Point& point = points_[static_cast<std::size_t>(s.point)];
    const Vector3d in_left =
        camera.rotation * at.points[static_cast<std::size_t>(s.point)] + camera.translation;
    const auto& r = right_from_left_;
    const Vector3d x = s.right ? Vector3d(r.rotation * in_left + r.translation) : in_left;
    const double focal = focal_[s.right ? 1 : 0], inverse = 1 / x.z();
    const Vector2d projected = x.head<2>() * inverse;
    const Vector2d error = focal * (projected - s.ray);
    const double weight = s.weight / (1 + error.squaredNorm() / unit);
    Matrix23 by_x;
    by_x << inverse, 0, -projected.x() * inverse, 0, inverse, -projected.y() * inverse;
    by_x *= focal;
    if (s.right) by_x = (by_x * r.rotation).eval();
    Matrix23 by_point;
    if (point.free) {
      by_point = by_x * camera.rotation;
      const Matrix23 weighted = weight * by_point;
      point.normal.noalias() += weighted.transpose() * by_point;
      point.gradient.noalias() -= weighted.transpose() * error;
    }
    const int pose = pose_of_[static_cast<std::size_t>(s.image)];
    if (pose < 0) continue;
    Eigen::Matrix<double, 2, 6> by_pose;
    by_pose.leftCols<3>() = -by_x * cross_matrix(in_left);
    by_pose.rightCols<3>() = by_x;
    const Eigen::Matrix<double, 2, 6> weighted = weight * by_pose;
    blocks_[static_cast<std::size_t>(pose)].noalias() += weighted.transpose() * by_pose;
    gradient_.segment<6>(6 * pose).noalias() -= weighted.transpose() * error;
    if (s.cell >= 0) {
      cells_[static_cast<std::size_t>(s.cell)].cross.noalias() += weighted.transpose() * by_point;
    }
  }
}

void NormalEquations::hold_distances(const Unknowns& at) {
  held_.clear();
  for (std::size_t i = 0; i < a_.images.size(); ++i) {
    if (pose_of_[i] < 0 || !a_.images[i].distance_fixed) continue;
    // Turning the camera about its map's origin changes nothing of the distance.
    const Vector3d along = at.camera_from_map[i].translation.normalized();
    held_.emplace_back(pose_of_[i], kKnown * kKnown * along * along.transpose());
  }
}

void NormalEquations::add_verticals(const Unknowns& at) {
  by_up_.assign(static_cast<std::size_t>(poses_), Matrix62::Zero());
  up_normal_.setZero();
  up_tangent_ = tangent(at.up);
  for (const auto& v : a_.verticals) {
    const auto image = static_cast<std::size_t>(v.image);
    const Matrix3d rotation = at.camera_from_map[image].rotation.toRotationMatrix();
    const Vector3d up = rotation * at.up, error = vertical_error(v, up);
    const double scale = kTypical_px / v.sigma;
    const double weight = 1 / (1 + error.squaredNorm() / (robust_px_ * robust_px_));
    const Eigen::Matrix<double, 3, 2> by_up = scale * rotation * up_tangent_;
    if (is_up_free()) {
      up_normal_ += weight * by_up.transpose() * by_up;
      gradient_.tail<2>() -= weight * by_up.transpose() * error;
    }
    const int pose = pose_of_[image];
    if (pose < 0) continue;
    const Matrix3d by_rotation = -scale * cross_matrix(up);
    blocks_[static_cast<std::size_t>(pose)].topLeftCorner<3, 3>() +=
        weight * by_rotation.transpose() * by_rotation;
    gradient_.segment<3>(6 * pose) -= weight * by_rotation.transpose() * error;
    by_up_[static_cast<std::size_t>(pose)].topRows<3>() += weight * by_rotation.transpose() * by_up;
  }
}

// Calls visit(image, point or -1, error).
template <class Visit>
void NormalEquations::for_each_sensor(const Unknowns& at, Visit visit) const {
  const auto pose = [&](int image) -> const Rigid3& {
    return at.camera_from_map[static_cast<std::size_t>(image)];
  };
  for (const auto& h : a_.headings) visit(h.image, -1, error_of(h, pose(h.image)));
  for (const auto& h : a_.heights) visit(h.image, -1, error_of(h, pose(h.image)));
  for (const auto& r : a_.ranges) {
    const Vector3d& x = at.points[static_cast<std::size_t>(r.point)];
    visit(r.image, r.point, error_of(r, pose(r.image), x));
  }
}

void NormalEquations::add_sensors(const Unknowns& at) {
  for_each_sensor(at, [&](int image, int index, const SensorError& e) {
    const double weight = 1 / (1 + e.px * e.px / (robust_px_ * robust_px_));
    const int pose = pose_of_[static_cast<std::size_t>(image)];
    if (pose >= 0) {
      blocks_[static_cast<std::size_t>(pose)] += weight * e.by_pose.transpose() * e.by_pose;
      gradient_.segment<6>(6 * pose) -= weight * e.px * e.by_pose.transpose();
    }
    if (index < 0) return;
    Point& point = points_[static_cast<std::size_t>(index)];
    if (!point.free) return;
    point.normal += weight * e.by_point.transpose() * e.by_point;
    point.gradient -= weight * e.px * e.by_point.transpose();
    for (int i = point.first_cell; i < point.end_cell; ++i) {
      Cell& cell = cells_[static_cast<std::size_t>(i)];
      if (cell.pose == pose) cell.cross += weight * e.by_pose.transpose() * e.by_point;
    }
  });
}

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
      result.gradient.segment<6>(6 * first.pose).noalias() -= solved * point.gradient;
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
    const Vector6 x = poses.segment<6>(6 * pose);
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
      rest.noalias() -= cell.cross.transpose() * poses.segment<6>(6 * cell.pose);
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
    const Vector6 x = poses.segment<6>(6 * pose_of_[i]);
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
    matrix.block<6, 6>(6 * block_poses_[i].first, 6 * block_poses_[i].second) = result.blocks[i];
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
