// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Corners of an image and their binary descriptors (FAST + ORB on the locally equalised image).
#pragma once

#include <opencv2/core/mat.hpp>

#include "nadir/core/frame.hpp"
#include "nadir/core/key_frame.hpp"
#include "nadir/odometry/correspondence.hpp"

namespace nadir::odometry {

/// About `wanted` corners spread over the image; fewer, or none, where there is no structure.
/// A low `threshold` (FAST, grey levels) finds weak corners of dim images.
Features detect_features(const cv::Mat& grey, const CameraModel& camera, int wanted,
                         int threshold = 7);

/// The same, at most 640 px wide: enough to recognise ground by.
cv::Mat small_picture(const cv::Mat& grey);

/// A frame prepared for odometry. It holds the images and dies with its window.
struct View {
  std::shared_ptr<const Frame> frame;
  Features features;
  double sharpness = 0;  ///< variance of the Laplacian, grey levels squared
  double exposure = 0;   ///< mean grey level

  const CameraModel& camera() const { return frame->rig->left; }
};

std::shared_ptr<View> prepare_view(std::shared_ptr<const Frame> frame, int wanted);

}  // namespace nadir::odometry
