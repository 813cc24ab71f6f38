// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether a calibration fits the images taken with it: a bundle adjustment that frees the lens, the
// pair and the moment of the right image too (self-calibration).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "nadir/core/key_frame.hpp"

namespace nadir::odometry {

struct Estimate {
  double value = 0, sigma = 0;
};

/// One camera. "Refined" is the lens the images ask for.
struct LensFit {
  CameraModel refined;
  Estimate focal_ratio;  ///< refined to given, mean of x and y
  /// Where the two lenses are farthest apart on the image, in pixels; a turn and a zoom, which
  /// poses and distances take up, are left out.
  Estimate distortion_px;
  /// Residuals by distance from the image's centre, of the given calibration: quarters of the half
  /// diagonal, innermost first; 0 where nothing was seen.
  std::array<double, 4> rms_px{};
};

struct PairFit {
  double epipolar_px = 0;          ///< median distance from the epipolar lines as given
  double refined_epipolar_px = 0;  ///< as refined
  Estimate delay_s;                ///< right image after the left; sigma 0: not known
};

struct CalibrationFit {
  int images = 0, observations = 0;
  double rms_px = 0, refined_rms_px = 0;
  LensFit left;
  std::optional<LensFit> right;
  std::optional<PairFit> pair;
};

constexpr std::size_t kMostKeyFramesFitted = 100;

/// Key frames of one rig, in order, of any number of sub-maps; at most the first
/// kMostKeyFramesFitted are used.
/// None when they are too few or hold too little (50 tie points each on average).
std::optional<CalibrationFit> fit_calibration(
    const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames);

/// What speaks against the calibration the fit started from; empty when nothing does.
std::vector<Alert> doubts(const CalibrationFit& fit);

}  // namespace nadir::odometry
