// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What odometry leaves of a key frame once nothing of it changes any more: enough to recognise its
// ground later and to adjust the whole map.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "nadir/core/camera_model.hpp"
#include "nadir/core/window.hpp"

namespace nadir {

/// Corners of an image and their binary descriptors, or blobs and theirs. Parallel arrays; of
/// corners the finest level first, within a level the strongest corner first.
struct Features {
  std::vector<Eigen::Vector2d> pixels;  ///< of the original, distorted image
  std::vector<Eigen::Vector2d> rays;    ///< normalised undistorted coordinates (x/z, y/z)
  cv::Mat descriptors;  ///< CV_8U, one row a feature; 32 columns of bits, or of blobs 128 numbers

  int size() const { return static_cast<int>(pixels.size()); }
};

/// A tie point in a key frame: normalised undistorted coordinates, and those in the right image of
/// a pair.
struct TiePointObservation {
  std::uint64_t tie_point = 0;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
  std::optional<Eigen::Vector2d> right_ray;
  Eigen::Vector3d x_in_survey = Eigen::Vector3d::Zero();  ///< of the tie point
};

struct SettledKeyFrame {
  ImagePose pose;
  SurveyAxes axes = SurveyAxes::none;  ///< of its sub-map
  std::shared_ptr<const CameraRig> rig;
  Features features;
  std::vector<TiePointObservation> observations;
  std::vector<std::uint8_t> picture;  ///< grey JPEG, reduced
};

}  // namespace nadir
