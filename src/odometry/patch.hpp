// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Sub-pixel image coordinates of a tie point: the patch around it in its first image, warped to
// look as in another image, is correlated there (least squares matching; gain and offset free).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace nadir::odometry {

/// Grey levels around a whole pixel of a tie point's first image.
struct Patch {
  static constexpr int kRadius = 10;
  static constexpr int kSide = 2 * kRadius + 1;
  std::array<std::uint8_t, std::size_t{kSide} * kSide> grey{};
};

/// None near the border of the image.
std::optional<Patch> cut_patch(const cv::Mat& grey, const Eigen::Vector2i& centre);

/// What a patch should look like in another image: zero mean, unit norm, with its gradients.
struct Template {
  static constexpr int kRadius = 5;
  static constexpr int kSide = 2 * kRadius + 1;
  static constexpr int kArea = kSide * kSide;
  using Values = Eigen::Matrix<float, kArea, 1>;
  Values value;
  std::array<std::int16_t, kArea> whole{};  ///< the value in units of 1 / 4096, for fast search
  Eigen::Matrix<float, kArea, 2> gradient;
  Eigen::Matrix2f inverse_normal;  ///< of the normal equations
};

/// image_from_patch: local affine map of pixel offsets. None without texture in two directions.
std::optional<Template> warp_patch(const Patch& patch, const Eigen::Matrix2d& image_from_patch);

struct Sight {
  Eigen::Vector2d pixel;
  double correlation = 0;  ///< normalised, -1 to 1
};

/// Correlation at a whole pixel; -1 outside the image.
float correlation(const Template& wanted, const cv::Mat& grey, int x, int y);

/// Best whole pixel within `radius` of the start.
Sight search(const Template& wanted, const cv::Mat& grey, const Eigen::Vector2d& start, int radius);

/// Least squares matching from a start within about 2 px: shifted, and where that leaves a
/// difference also sheared and scaled, as relief and tilt ask for. None when it does not converge
/// or leaves the image.
std::optional<Sight> refine(const Template& wanted, const cv::Mat& grey,
                            const Eigen::Vector2d& start);

}  // namespace nadir::odometry
