// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/bundle_adjustment.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <cmath>
#include <limits>
#include <memory>

namespace nadir::odometry {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;
using Pose = std::array<double, 7>;  // quaternion x y z w, translation; camera_from_map
using PoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

// Seen from the map's origin, the camera stays as far away as it was.
using DistantPoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::SphereManifold<3>>;

double mean_focal(const CameraModel& camera) { return 0.5 * (camera.fx + camera.fy); }

Matrix3d cross_matrix(const Vector3d& v) {
  return Matrix3d{{0, -v.z(), v.y()}, {v.z(), 0, -v.x()}, {-v.y(), v.x(), 0}};
}

// Reprojection error in pixels of the undistorted image, with its derivatives.
class Reprojection final : public ceres::SizedCostFunction<2, 7, 3> {
 public:
  Reprojection(const Vector2d& ray, double focal, const Rigid3* right_from_left)
      : ray_(ray), focal_(focal) {
    if (right_from_left == nullptr) return;
    rotation_ = right_from_left->rotation.toRotationMatrix();
    translation_ = right_from_left->translation;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[0]);
    const Eigen::Map<const Vector3d> t(parameters[0] + 4), x(parameters[1]);
    const Matrix3d rotation = q.toRotationMatrix();
    const Vector3d in_camera = rotation_ * (rotation * x + t) + translation_;
    if (!(in_camera.z() > 1e-6)) return false;
    const double inverse = 1 / in_camera.z();
    const Vector2d projected = in_camera.head<2>() * inverse;
    Eigen::Map<Vector2d> error(residuals);
    error = focal_ * (projected - ray_);
    if (jacobians == nullptr) return true;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << inverse, 0, -projected.x() * inverse, 0, inverse, -projected.y() * inverse;
    by_point = (focal_ * by_point * rotation_).eval();
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> j(jacobians[0]);
      const Vector3d u = q.vec();
      j.leftCols<3>() = 2 * by_point *
                        (-q.w() * cross_matrix(x) + u.dot(x) * Matrix3d::Identity() +
                         u * x.transpose() - 2 * x * u.transpose());
      j.col(3) = 2 * by_point * u.cross(x);
      j.rightCols<3>() = by_point;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> j(jacobians[1]);
      j = by_point * rotation;
    }
    return true;
  }

 private:
  Vector2d ray_;
  double focal_;
  Matrix3d rotation_ = Matrix3d::Identity();
  Vector3d translation_ = Vector3d::Zero();
};

// Up as the AHRS has it in a camera, and as the map has it there.
struct VerticalError {
  Vector3d up_in_camera;
  double weight = 1;

  template <class T>
  bool operator()(const T* pose, const T* up_in_map, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> up(up_in_map);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> error(residuals);
    error = T(weight) * (q * up - up_in_camera.cast<T>());
    return true;
  }
};

// The cost is in pixels, which tie points hold to a fifth of one.
constexpr double kTypical_px = 0.2;

Pose to_parameters(const Rigid3& r) {
  const auto& q = r.rotation;
  return {q.x(), q.y(), q.z(), q.w(), r.translation.x(), r.translation.y(), r.translation.z()};
}

Rigid3 to_rigid(const Pose& p) {
  return {Eigen::Quaterniond(p[3], p[0], p[1], p[2]).normalized(), {p[4], p[5], p[6]}};
}

double error_px(const Adjustment& a, const CameraRig& rig, const Adjustment::Observation& o) {
  Vector3d x = a.images[static_cast<std::size_t>(o.image)].camera_from_map *
               a.points[static_cast<std::size_t>(o.point)].x_in_map;
  if (o.right) x = rig.right->right_from_left * x;
  if (!(x.z() > 1e-6)) return std::numeric_limits<double>::infinity();
  const double error = (x.head<2>() / x.z() - o.ray).norm();
  return mean_focal(o.right ? rig.right->camera : rig.left) * error;
}

// Where the solution starts.
Vector3d up_of(const Adjustment& a) {
  if (a.up_in_map) return *a.up_in_map;
  if (a.verticals.empty()) return Vector3d::UnitZ();
  const auto& first = a.verticals.front();
  const Rigid3& pose = a.images[static_cast<std::size_t>(first.image)].camera_from_map;
  return pose.rotation.conjugate() * first.up_in_camera;
}

bool is_finite(const std::vector<Pose>& poses, const std::vector<Vector3d>& points) {
  for (const Pose& p : poses) {
    for (const double v : p) {
      if (!std::isfinite(v)) return false;
    }
  }
  for (const Vector3d& x : points) {
    if (!x.allFinite()) return false;
  }
  return true;
}

double robust_rms(Adjustment& a, const CameraRig& rig, double robust_px) {
  double sum = 0, weights = 0;
  for (auto& o : a.observations) {
    o.error_px = error_px(a, rig, o);
    if (!std::isfinite(o.error_px)) continue;
    const double ratio = o.error_px / robust_px, weight = 1 / (1 + ratio * ratio);
    sum += weight * o.error_px * o.error_px;
    weights += weight;
  }
  return weights > 0 ? std::sqrt(sum / weights) : 0.0;
}

ceres::Solver::Options solver_options(const AdjustmentOptions& wanted, bool points_free,
                                      std::size_t images) {
  constexpr std::size_t kManyImages = 60;  // a dense matrix of their poses costs more than a sparse
  ceres::Solver::Options options;
  options.linear_solver_type = !points_free           ? ceres::DENSE_QR
                               : images > kManyImages ? ceres::SPARSE_SCHUR
                                                      : ceres::DENSE_SCHUR;
  options.max_num_iterations = wanted.iterations;
  options.function_tolerance = wanted.tolerance;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

AdjustmentSummary adjust(Adjustment& a, const CameraRig& rig, const AdjustmentOptions& options) {
  std::vector<Pose> poses;
  std::vector<Vector3d> points;
  for (const auto& image : a.images) poses.push_back(to_parameters(image.camera_from_map));
  for (const auto& point : a.points) points.push_back(point.x_in_map);

  PoseManifold manifold;
  DistantPoseManifold distant_manifold;
  ceres::CauchyLoss loss(options.robust_px);
  std::vector<std::unique_ptr<ceres::ScaledLoss>> weighted;
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (const auto& o : a.observations) {
    if (!std::isfinite(error_px(a, rig, o))) continue;
    const CameraModel& camera = o.right ? rig.right->camera : rig.left;
    ceres::LossFunction* of_this = &loss;
    if (o.weight != 1) {
      weighted.push_back(
          std::make_unique<ceres::ScaledLoss>(&loss, o.weight, ceres::DO_NOT_TAKE_OWNERSHIP));
      of_this = weighted.back().get();
    }
    problem.AddResidualBlock(new Reprojection(o.ray, mean_focal(camera),
                                              o.right ? &rig.right->right_from_left : nullptr),
                             of_this, poses[static_cast<std::size_t>(o.image)].data(),
                             points[static_cast<std::size_t>(o.point)].data());
  }
  Vector3d up = up_of(a);
  for (const auto& vertical : a.verticals) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<VerticalError, 3, 7, 3>(
            new VerticalError{vertical.up_in_camera, kTypical_px / vertical.sigma}),
        &loss, poses[static_cast<std::size_t>(vertical.image)].data(), up.data());
  }
  ceres::SphereManifold<3> sphere;
  if (!a.verticals.empty()) {
    problem.SetManifold(up.data(), &sphere);
    if (a.up_in_map) problem.SetParameterBlockConstant(up.data());
  }
  bool points_free = false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].data())) continue;
    if (a.images[i].distance_fixed) {
      problem.SetManifold(poses[i].data(), &distant_manifold);
    } else {
      problem.SetManifold(poses[i].data(), &manifold);
    }
    if (a.images[i].fixed) problem.SetParameterBlockConstant(poses[i].data());
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!problem.HasParameterBlock(points[i].data())) continue;
    if (a.points[i].fixed)
      problem.SetParameterBlockConstant(points[i].data());
    else
      points_free = true;
  }

  // What a solver could not do is in its summary; the diver's terminal is not its log.
  [[maybe_unused]] static const int kQuiet = FLAGS_minloglevel = google::GLOG_FATAL;
  AdjustmentSummary result;
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options, points_free, poses.size()), &problem, &summary);
  result.usable = summary.IsSolutionUsable() && is_finite(poses, points);
  result.iterations = static_cast<int>(summary.iterations.size());
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  if (result.usable) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (!a.images[i].fixed) a.images[i].camera_from_map = to_rigid(poses[i]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) a.points[i].x_in_map = points[i];
  }
  result.rms_px = robust_rms(a, rig, options.robust_px);
  return result;
}

}  // namespace nadir::odometry
