// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How well an adjusted bundle knows its poses.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "nadir/odometry/bundle_adjustment.hpp"

namespace nadir::odometry {

/// From the normal equations at the solution, tie points eliminated, sensors left out, weights as
/// the robust loss saw them, the unit weight from the residuals.
class PoseCovariance {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// None when a free image is not determined.
  static std::optional<PoseCovariance> of(const Adjustment& adjusted, const CameraRig& rig,
                                          double robust_px);

  /// Of camera_from_map's (rotation vector, translation), both small and applied from the left;
  /// zero for a fixed image.
  Matrix6 of_image(int image) const;

  /// Of second_from_first's (rotation vector, translation), both small and applied from the left.
  /// Fixed images are taken as exact.
  Matrix6 relative(const Adjustment& adjusted, int first, int second) const;

 private:
  Eigen::MatrixXd covariance_;
  std::vector<int> column_of_;  ///< by image; -1: fixed
};

/// 1 sigma of a relative pose, survey units and radians. Roots of the sums of three variances.
struct Sigmas {
  double position = 0, rotation = 0;
};
Sigmas sigmas_of(const PoseCovariance::Matrix6& relative);

}  // namespace nadir::odometry
