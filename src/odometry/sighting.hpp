// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Finding a tie point in an image whose pose is (nearly) known.
#pragma once

#include "map.hpp"

namespace nadir::odometry {

/// An image with its camera and pose.
struct Looking {
  const cv::Mat& grey;
  const CameraModel& camera;
  Rigid3 camera_from_map;
};

/// How offsets of pixels around a point of the ground go from one image to the other.
/// None where the ground is seen edge-on or not at all.
std::optional<Eigen::Matrix2d> local_affine(const CameraModel& host, const Rigid3& host_from_map,
                                            const Eigen::Vector2d& host_pixel,
                                            const Eigen::Vector3d& x_in_map,
                                            const Eigen::Vector3d& normal_in_map,
                                            const CameraModel& target,
                                            const Rigid3& target_from_map);

/// The sub-pixel place of a tie point within `radius` px of where the pose puts it, or of `start`.
std::optional<Sight> sight(const Map& map, const MapPoint& point, const Looking& image, int radius,
                           std::optional<Eigen::Vector2d> start = std::nullopt);

/// A point of unknown depth, by its place in one image, along its epipolar line in another.
struct Unplaced {
  Patch patch;
  Eigen::Vector2d pixel, ray;
  double inverse_depth_min = 0, inverse_depth_max = 0;
  Eigen::Vector3d normal_in_host;  ///< of the ground, camera frame of the host
};

struct Placed {
  Sight sight;
  Eigen::Vector2d ray;
  double inverse_depth = 0;  ///< where on the epipolar line
};

/// None when nothing, or more than one place, looks alike. `across`: px to either side of the line.
std::optional<Placed> search_epipolar_line(const Unplaced& point, const CameraModel& host,
                                           const CameraModel& target,
                                           const Rigid3& target_from_host, const cv::Mat& grey,
                                           int across);

}  // namespace nadir::odometry
