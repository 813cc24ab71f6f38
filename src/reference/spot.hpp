// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A bright round spot on an uneven background, to a fraction of a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace nadir::reference {

/// background + slope . (p - centre) + amplitude exp(-|p - centre|^2 / (2 sigma^2))
struct Spot {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< px
  double amplitude = 0;                              ///< grey levels above the background
  double sigma = 0;                                  ///< px
  double background = 0;                             ///< grey levels at the centre
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();   ///< of the background, grey levels per px
  double rms = 0;                                    ///< of the residuals, grey levels
  double sigma_centre = 0;                           ///< px per axis, as the residuals say
};

/// The spot within radius px of start, fitted by least squares (Levenberg-Marquardt). Where
/// `at_least` (CV_8UC1, of the image's size) is not zero the spot may be brighter than the value.
/// None when the disc is not wholly in the image, or nothing in it is like a spot.
std::optional<Spot> fit_spot(const cv::Mat1f& image, const cv::Mat1b& at_least,
                             const Eigen::Vector2d& start, double radius);

}  // namespace nadir::reference
