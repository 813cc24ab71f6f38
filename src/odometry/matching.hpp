// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Correspondences between descriptors.
#pragma once

#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

#include "features.hpp"

namespace nadir::odometry {

using Pairs = std::vector<std::pair<int, int>>;  ///< row of the first, row of the second

/// Of corners; else of blobs.
bool is_binary(const cv::Mat& descriptors);

/// Mutual best descriptors of which the first is clearly better than the second best (ratio of
/// Hamming distances, of blobs' Euclidean ones).
Pairs match_descriptors(const cv::Mat& first, const cv::Mat& second, double ratio);

/// For each expected place (pixels of the second image, parallel to the rows of `first`; not finite
/// = not expected there) the feature within the radius with the most similar binary descriptor.
Pairs match_near(const cv::Mat& first, const std::vector<Eigen::Vector2d>& expected,
                 const Features& second, double radius_px, int max_distance);

}  // namespace nadir::odometry
