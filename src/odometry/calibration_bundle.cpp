// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_bundle.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "epipolar.hpp"
#include "median.hpp"
#include "nadir/odometry/self_calibration.hpp"

namespace nadir::odometry {
namespace {

using Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kFewestTiePoints = 50;

// What is known beforehand of numbers that a survey of flat ground says little of: 1 sigma.
constexpr double kFocal = 0.3, kPrincipalPoint = 0.05;  // of the focal length, of the width
constexpr double kRadial = 0.3, kTangential = 0.01;
constexpr double kDelay_s = 0.05;
constexpr double kTypical_px = 0.2;  // error of a tie point, against which these are weighed

Pose to_parameters(const Rigid3& r) {
  const auto& q = r.rotation;
  return {q.x(), q.y(), q.z(), q.w(), r.translation.x(), r.translation.y(), r.translation.z()};
}

Rigid3 to_rigid(const Pose& p) {
  return {Eigen::Quaterniond(p[3], p[0], p[1], p[2]).normalized(), {p[4], p[5], p[6]}};
}

bool is_fisheye(const CameraModel& camera) { return camera.lens == LensModel::kannala_brandt; }

// 1 sigma of each number of a lens.
Lens known_beforehand(const CameraModel& camera) {
  const double focal = kFocal * camera.fx, centre = kPrincipalPoint * camera.width;
  const double third = is_fisheye(camera) ? kRadial : kTangential;
  return {focal, focal, centre, centre, kRadial, kRadial, third, third, kRadial};
}

// CameraModel::project for numbers of any kind; the higher coefficients stay as they are.
template <class T>
Eigen::Matrix<T, 2, 1> project(const CameraModel& camera, const T* lens,
                               const Eigen::Matrix<T, 3, 1>& x_in_camera) {
  using std::atan, std::sqrt;
  const Eigen::Matrix<T, 2, 1> p = x_in_camera.template head<2>() / x_in_camera.z();
  const T* k = lens + 4;
  const T r2 = p.squaredNorm();
  Eigen::Matrix<T, 2, 1> bent;
  if (is_fisheye(camera)) {
    const T r = sqrt(r2 + T(1e-18)), theta = atan(r), t2 = theta * theta;
    bent = p * (theta / r * (T(1) + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))));
  } else {
    const auto& d = camera.distortion;
    const T radial = (T(1) + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) /
                     (T(1) + r2 * (T(d[5]) + r2 * (T(d[6]) + r2 * T(d[7]))));
    const T xy2 = T(2) * p.x() * p.y();
    bent << p.x() * radial + k[2] * xy2 + k[3] * (r2 + T(2) * p.x() * p.x()),
        p.y() * radial + k[2] * (r2 + T(2) * p.y() * p.y()) + k[3] * xy2;
  }
  return {lens[0] * bent.x() + lens[2], lens[1] * bent.y() + lens[3]};
}

template <class T>
Eigen::Matrix<T, 3, 1> transform(const T* pose, const Eigen::Matrix<T, 3, 1>& x) {
  const Eigen::Map<const Eigen::Quaternion<T>> q(pose);
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(pose + 4);
  return q * x + t;
}

struct SeenLeft {
  const CameraModel& camera;
  Vector2d pixel;

  template <class T>
  bool operator()(const T* camera_from_map, const T* point, const T* lens, T* error) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Vector3 x = transform<T>(camera_from_map, Eigen::Map<const Vector3>(point));
    if (!(x.z() > T(1e-6))) return false;
    Eigen::Map<Eigen::Matrix<T, 2, 1>> e(error);
    e = project(camera, lens, x) - pixel.cast<T>();
    return true;
  }
};

// By the right camera, some time after the left.
struct SeenRight {
  const CameraModel& camera;
  Vector2d pixel;
  Twist motion;

  template <class T>
  bool operator()(const T* camera_from_map, const T* point, const T* lens, const T* right_from_left,
                  const T* delay, T* error) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    Vector3 x = transform<T>(camera_from_map, Eigen::Map<const Vector3>(point));
    const Vector3 turn = motion.head<3>().cast<T>(), shift = motion.tail<3>().cast<T>();
    x += *delay * (turn.cross(x) + shift);
    x = transform<T>(right_from_left, x);
    if (!(x.z() > T(1e-6))) return false;
    Eigen::Map<Eigen::Matrix<T, 2, 1>> e(error);
    e = project(camera, lens, x) - pixel.cast<T>();
    return true;
  }
};

struct Expected {
  Lens value, sigma;

  template <class T>
  bool operator()(const T* lens, T* error) const {
    for (std::size_t i = 0; i < value.size(); ++i) {
      error[i] = kTypical_px / sigma[i] * (lens[i] - value[i]);
    }
    return true;
  }
};

struct NoDelay {
  template <class T>
  bool operator()(const T* delay, T* error) const {
    *error = kTypical_px / kDelay_s * *delay;
    return true;
  }
};

// Motion of the camera at an image, by its neighbours in time; none where they are far.
std::optional<Twist> motion_at(const std::vector<ImagePose>& poses, std::size_t i) {
  constexpr double kMost_s = 5;
  const auto near = [&](std::size_t k) {
    return poses[k].submap == poses[i].submap &&
           std::abs(seconds(poses[k].time - poses[i].time)) < kMost_s;
  };
  const std::size_t before = i > 0 && near(i - 1) ? i - 1 : i;
  const std::size_t after = i + 1 < poses.size() && near(i + 1) ? i + 1 : i;
  const double elapsed = seconds(poses[after].time - poses[before].time);
  if (!(elapsed > 0)) return std::nullopt;
  const Rigid3 step = poses[after].survey_from_camera.inverse() * poses[before].survey_from_camera;
  const Eigen::AngleAxisd turn(step.rotation);
  Twist motion;
  motion << turn.angle() * turn.axis() / elapsed, step.translation / elapsed;
  return motion;
}

}  // namespace

Lens to_parameters(const CameraModel& camera) {
  const auto& d = camera.distortion;
  return {camera.fx, camera.fy, camera.cx, camera.cy, d[0], d[1], d[2], d[3], d[4]};
}

CameraModel with(CameraModel camera, const Lens& lens) {
  camera.fx = lens[0];
  camera.fy = lens[1];
  camera.cx = lens[2];
  camera.cy = lens[3];
  std::copy(lens.begin() + 4, lens.end(), camera.distortion.begin());
  return camera;
}

CalibrationBundle::CalibrationBundle(
    const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames)
    : rig_(*key_frames.front()->rig) {
  std::unordered_map<std::uint64_t, std::size_t> index_of;
  std::map<std::uint32_t, Rigid3> survey_from_map;
  for (const auto& key_frame : key_frames) {
    if (poses_.size() == kMostKeyFramesFitted) break;
    const std::size_t image = poses_.size();
    const ImagePose& pose = key_frame->pose;
    given_poses_.push_back(pose);
    const Rigid3& origin =
        survey_from_map.try_emplace(pose.submap, pose.survey_from_camera).first->second;
    poses_.push_back(to_parameters(pose.survey_from_camera.inverse() * origin));
    for (const TiePointObservation& seen : key_frame->observations) {
      const auto left = rig_.left.project(seen.ray.homogeneous());
      if (!left) continue;
      const auto [known, is_new] = index_of.try_emplace(seen.tie_point, points_.size());
      if (is_new) points_.push_back(origin.inverse() * seen.x_in_survey);
      Observation o{image, known->second, *left, {}};
      if (rig_.right && seen.right_ray) {
        o.right = rig_.right->camera.project(seen.right_ray->homogeneous());
      }
      observations_.push_back(o);
    }
  }
  drop_single_rays();
  for (const Observation& o : observations_) pairs_ += o.right ? 1 : 0;
  for (std::size_t i = 0; i < poses_.size(); ++i) motion_.push_back(motion_at(given_poses_, i));
  left_ = to_parameters(rig_.left);
  if (rig_.right) {
    right_ = to_parameters(rig_.right->camera);
    right_from_left_ = to_parameters(rig_.right->right_from_left);
    timed_ = std::ranges::any_of(motion_, [](const auto& motion) { return motion.has_value(); });
  }
}

// They place no point.
void CalibrationBundle::drop_single_rays() {
  std::vector<int> rays(points_.size(), 0);
  for (const Observation& o : observations_) rays[o.point] += o.right ? 2 : 1;
  std::erase_if(observations_, [&](const Observation& o) { return rays[o.point] < 2; });
}

CameraRig CalibrationBundle::refined() const {
  CameraRig rig = rig_;
  rig.left = with(rig.left, left_);
  if (rig.right) {
    rig.right->camera = with(rig.right->camera, right_);
    rig.right->right_from_left = to_rigid(right_from_left_);
  }
  return rig;
}

void CalibrationBundle::add_observations() {
  for (const Observation& o : observations_) {
    double* point = points_[o.point].data();
    if (!((to_rigid(poses_[o.image]) * points_[o.point]).z() > 1e-3)) continue;
    problem_->AddResidualBlock(
        new ceres::AutoDiffCostFunction<SeenLeft, 2, 7, 3, 9>(new SeenLeft{rig_.left, o.left}),
        &loss_, poses_[o.image].data(), point, left_.data());
    if (!o.right) continue;
    problem_->AddResidualBlock(
        new ceres::AutoDiffCostFunction<SeenRight, 2, 7, 3, 9, 7, 1>(new SeenRight{
            rig_.right->camera, *o.right, motion_[o.image].value_or(Twist::Zero().eval())}),
        &loss_, poses_[o.image].data(), point, right_.data(), right_from_left_.data(), &delay_);
  }
}

// Every sub-map's first camera holds its frame; of single cameras the farthest holds the scale.
void CalibrationBundle::hold_frames() {
  struct Ends {
    std::size_t first, farthest;
  };
  std::map<std::uint32_t, Ends> maps;
  const auto distance = [&](std::size_t i) { return to_rigid(poses_[i]).translation.norm(); };
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (!problem_->HasParameterBlock(poses_[i].data())) continue;
    problem_->SetManifold(poses_[i].data(), &pose_manifold_);
    Ends& ends = maps.try_emplace(given_poses_[i].submap, Ends{i, i}).first->second;
    if (distance(i) > distance(ends.farthest)) ends.farthest = i;
  }
  for (const auto& [submap, ends] : maps) {
    problem_->SetParameterBlockConstant(poses_[ends.first].data());
    if (!has_pair() && ends.farthest != ends.first) {
      problem_->SetManifold(poses_[ends.farthest].data(), &distant_manifold_);
    }
  }
}

bool CalibrationBundle::rich() const {
  return observations_.size() >= kFewestTiePoints * poses_.size();
}

bool CalibrationBundle::solve(bool free_calibration) {
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(ownership);
  add_observations();
  hold_frames();
  const auto expect = [&](Lens& lens, const CameraModel& camera) {
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Expected, 9, 9>(
                                   new Expected{to_parameters(camera), known_beforehand(camera)}),
                               nullptr, lens.data());
    if (!free_calibration) problem_->SetParameterBlockConstant(lens.data());
  };
  expect(left_, rig_.left);
  if (has_pair()) {
    expect(right_, rig_.right->camera);
    problem_->SetManifold(right_from_left_.data(), &distant_manifold_);
    if (!free_calibration) problem_->SetParameterBlockConstant(right_from_left_.data());
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<NoDelay, 1, 1>(new NoDelay{}),
                               nullptr, &delay_);
    if (!free_calibration || !timed_) problem_->SetParameterBlockConstant(&delay_);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-7;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  // What a solver could not do is in its summary; the diver's terminal is not its log.
  [[maybe_unused]] static const int kQuiet = FLAGS_minloglevel = google::GLOG_FATAL;
  ceres::Solve(options, problem_.get(), &summary);
  return summary.IsSolutionUsable();
}

std::vector<CalibrationBundle::Error> CalibrationBundle::errors() const {
  const CameraRig rig = refined();
  std::vector<Error> all;
  const auto add = [&](const CameraModel& camera, const Vector3d& x, const Vector2d& pixel,
                       bool right) {
    const auto again = camera.project(x);
    if (!again) return;
    const Vector2d half(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
    all.push_back({(*again - pixel).norm(), (pixel - half).norm() / half.norm(), right});
  };
  for (const Observation& o : observations_) {
    const Vector3d x = to_rigid(poses_[o.image]) * points_[o.point];
    add(rig.left, x, o.left, false);
    if (!o.right) continue;
    const Twist motion = delay_ * motion_[o.image].value_or(Twist::Zero().eval());
    const Vector3d then = x + motion.head<3>().cross(x) + motion.tail<3>();
    add(rig.right->camera, rig.right->right_from_left * then, *o.right, true);
  }
  return all;
}

double CalibrationBundle::epipolar_px() const {
  const CameraRig rig = refined();
  const CameraRig::Right& right = *rig.right;
  std::vector<double> distances;
  for (const Observation& o : observations_) {
    if (!o.right) continue;
    const auto a = rig.left.unproject(o.left), b = right.camera.unproject(*o.right);
    if (!a || !b) continue;
    if (const auto distance = epipolar_distance_px(right, *a, *b)) distances.push_back(*distance);
  }
  return median(std::move(distances));
}

std::optional<CalibrationBundle::Covariance> CalibrationBundle::covariance() {
  std::vector<const double*> blocks{left_.data()};
  if (has_pair()) blocks.push_back(right_.data());
  const bool delay = has_pair() && timed_;
  if (delay) blocks.push_back(&delay_);
  std::vector<std::pair<const double*, const double*>> own;
  own.reserve(blocks.size());
  for (const double* block : blocks) own.emplace_back(block, block);
  ceres::Covariance estimate({});
  if (!estimate.Compute(own, problem_.get())) return std::nullopt;
  double cost = 0;
  problem_->Evaluate({}, &cost, nullptr, nullptr, nullptr);
  const int redundancy = problem_->NumResiduals() - problem_->NumParameters();
  if (redundancy <= 0) return std::nullopt;
  const double variance = 2 * cost / redundancy;
  const auto lens = [&](const Lens& of) {
    Eigen::Matrix<double, 9, 9, Eigen::RowMajor> found;
    estimate.GetCovarianceBlock(of.data(), of.data(), found.data());
    return MatrixXd(variance * found);
  };
  Covariance result;
  result.left = lens(left_);
  if (has_pair()) result.right = lens(right_);
  if (delay) {
    estimate.GetCovarianceBlock(&delay_, &delay_, &result.delay_s2);
    result.delay_s2 *= variance;
  }
  return result;
}

}  // namespace nadir::odometry
