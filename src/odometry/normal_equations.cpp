// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "normal_equations.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>

#include "nadir/core/clones.hpp"
#include "sensor_errors.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

constexpr double kNearest = 1e-6;  // in front of a camera

// Of a held distance, pixels per map unit: tie points of a camera one unit away hold it to a tenth.
constexpr double kKnown = 1e4;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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
  focal_ = {rig.left.mean_focal(), rig.left.mean_focal()};
  if (rig.right) {
    right_from_left_ = {rig.right->right_from_left.rotation.toRotationMatrix(),
                        rig.right->right_from_left.translation};
    focal_[1] = rig.right->camera.mean_focal();
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
    gradient_.segment<6>(row_of(pose)).noalias() -= weighted.transpose() * error;
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
    gradient_.segment<3>(row_of(pose)) -= weight * by_rotation.transpose() * error;
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
      gradient_.segment<6>(row_of(pose)) -= weight * e.px * e.by_pose.transpose();
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

}  // namespace nadir::odometry
