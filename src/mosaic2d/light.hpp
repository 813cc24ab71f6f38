// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The lamps' pattern: what is bright or dark at the same place of every image.
#pragma once

#include <opencv2/core/mat.hpp>

namespace nadir::mosaic2d {

/// Learns the pattern as the running mean of the images' log intensities, per channel and at low
/// resolution, and divides it out. The vehicle carries its lamps, so the pattern stays while the
/// seabed passes.
class LampPattern {
 public:
  /// The image (CV_8UC3) with the pattern known so far, itself included, divided out.
  cv::Mat flatten(const cv::Mat& bgr);

 private:
  void learn(const cv::Mat& bgr);

  cv::Mat mean_log_;  ///< CV_32FC3, low resolution
  cv::Mat gain_;      ///< CV_16UC3 at the images' size, kUnit is 1
  int images_ = 0;
};

/// Scales a projected image's channels, alpha kept; saturates.
void apply_gain(cv::Mat& bgra, const cv::Vec3d& gain);

}  // namespace nadir::mosaic2d
