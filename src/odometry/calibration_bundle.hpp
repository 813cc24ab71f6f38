// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A bundle adjustment that frees the calibration too.
#pragma once

#include <ceres/ceres.h>

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "nadir/core/key_frame.hpp"

namespace nadir::odometry {

using Lens = std::array<double, 9>;         ///< fx fy cx cy and the first five of distortion
using Pose = std::array<double, 7>;         ///< quaternion x y z w, translation; camera_from_map
using Twist = Eigen::Matrix<double, 6, 1>;  ///< rotation, translation a second, in the camera

Lens to_parameters(const CameraModel& camera);
CameraModel with(CameraModel camera, const Lens& lens);

constexpr double kRobust_px = 0.5;  ///< scale of its Cauchy loss

/// The whole adjustment; every sub-map in the frame of its first camera.
class CalibrationBundle {
 public:
  explicit CalibrationBundle(const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames);

  bool has_pair() const { return rig_.right.has_value() && pairs_ > 0; }
  const CameraRig& given() const { return rig_; }
  CameraRig refined() const;
  /// Residuals now, of observations that weigh as the robust loss sees them.
  struct Error {
    double px = 0, ring = 0;  ///< ring: distance from the centre in half diagonals
    bool right = false;
  };
  std::vector<Error> errors() const;
  /// Median distance of right pixels from the epipolar lines of left ones, as solved.
  double epipolar_px() const;
  std::size_t images() const { return poses_.size(); }
  int observations() const { return static_cast<int>(observations_.size()) + pairs_; }
  /// Whether images hold enough tie points, on average, to say something of the lens.
  bool rich() const;

  bool solve(bool free_calibration);

  struct Covariance {
    Eigen::MatrixXd left, right;  ///< of the nine numbers of a lens
    double delay_s2 = 0;
  };
  /// After the calibration was solved for; none when it could not be told.
  std::optional<Covariance> covariance();
  double delay_s() const { return delay_; }
  bool timed() const { return timed_; }

 private:
  using PoseManifold =
      ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;
  using DistantPoseManifold =
      ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::SphereManifold<3>>;
  struct Observation {
    std::size_t image = 0, point = 0;
    Eigen::Vector2d left;
    std::optional<Eigen::Vector2d> right;  // pixels
  };

  void drop_single_rays();
  void add_observations();
  void hold_frames();

  CameraRig rig_;
  std::vector<ImagePose> given_poses_;
  std::vector<Pose> poses_;
  std::vector<std::optional<Twist>> motion_;
  std::deque<Eigen::Vector3d> points_;
  std::vector<Observation> observations_;
  int pairs_ = 0;
  Lens left_{}, right_{};
  Pose right_from_left_{};
  double delay_ = 0;
  bool timed_ = false;

  PoseManifold pose_manifold_;
  DistantPoseManifold distant_manifold_;
  ceres::CauchyLoss loss_{kRobust_px};
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace nadir::odometry
