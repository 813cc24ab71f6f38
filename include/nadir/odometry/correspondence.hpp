// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Corners, or blobs, that two images have in common.
#pragma once

#include <utility>
#include <vector>

#include "nadir/core/key_frame.hpp"

namespace nadir::odometry {

/// Standard deviation of a described corner, in normalised coordinates of this camera.
double corner_sigma(const CameraModel& camera);

struct Correspondences {
  std::vector<std::pair<int, int>> pairs;  ///< features of the first, of the second
  double shift_px = 0;                     ///< median displacement
};

/// Correspondences that agree with one two-view geometry; of corners a second, guided pass where
/// the first finds few. Both corners, or both blobs.
Correspondences correspond(const Features& first, const Features& second,
                           const CameraModel& camera);

/// Blobs of a grey image of this camera at any size (SIFT, Lowe 2004): ten times as slow as
/// corners, and found again on dim, uneven seabeds where corners are not.
Features describe_blobs(const cv::Mat& grey, const CameraModel& camera);

/// Descriptors of the strongest corners that found their like, unverified: cheap, and clearly more
/// for images of the same ground.
int likeness(const Features& first, const Features& second);

}  // namespace nadir::odometry
