// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Relative orientation of two images from correspondences (paper 3.2, step i), for scenes with
// relief (essential matrix) and for flat ones (homography), where five points are ambiguous.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nadir/core/camera_model.hpp"

namespace nadir::odometry {

using Rays = std::vector<Eigen::Vector2d>;  ///< normalised undistorted coordinates

/// Which correspondences agree with one rigid two-view geometry, whatever it is.
struct Agreement {
  std::vector<int> inliers;  ///< indices of the correspondences, ascending
  Eigen::Matrix3d homography = Eigen::Matrix3d::Zero();  ///< second ~ H first; zero when none
};

/// sigma: standard deviation of a coordinate, normalised units. No inliers for fewer than 12
/// correspondences and where hardly any agree with one homography.
Agreement verify(const Rays& first, const Rays& second, double sigma);

struct RelativeOrientation {
  Rigid3 second_from_first;  ///< translation of unit length
  int inliers = 0;           ///< points in front of both cameras within 3 sigma
  double parallax = 0;       ///< median intersection angle, radians
};

/// The orientations that explain the (verified) correspondences about equally well, best first;
/// none when the images are too few, not related or taken from one place. Flat ground seen twice
/// may leave two: a third image decides.
std::vector<RelativeOrientation> relative_orientations(const Rays& first, const Rays& second,
                                                       const CameraModel& camera, double sigma);

}  // namespace nadir::odometry
