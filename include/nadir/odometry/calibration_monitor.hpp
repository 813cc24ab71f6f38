// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether a wrong calibration shows in the map while it grows.
#pragma once

#include <memory>
#include <vector>

#include "nadir/core/alert.hpp"
#include "nadir/core/key_frame.hpp"

namespace nadir::odometry {

/// Analysis of variance of reprojection residuals by cells of the image: sums of squares, px^2, of
/// the cells' means and within the cells about these means, and their degrees of freedom.
struct ResidualVariance {
  double between = 0, within = 0;
  double between_freedom = 0, within_freedom = 0;

  /// Variance between cells over that within (the F ratio): about 1 for errors that are independent
  /// from tie point to tie point; 0 without residuals.
  double ratio() const;
};

/// A lens that is not the calibrated one leaves like residuals in neighbouring tie points. Noise,
/// blur and mismatches leave independent ones, however large; what else is smooth on the image is
/// told apart by a self-calibration. That takes seconds: not for the thread that orients images.
class CalibrationMonitor {
 public:
  using KeyFrames = std::vector<std::shared_ptr<const SettledKeyFrame>>;

  /// Key frames as odometry settles them, in order; `last`: none will follow.
  /// Alerts when a self-calibration on the last key frames of their sub-map speaks against the
  /// calibration, with the newest one's image and time: once in a dive, after three attempts at
  /// most and one more at the end.
  std::vector<Alert> observe(const KeyFrames& settled, bool last);

 private:
  void add(const std::shared_ptr<const SettledKeyFrame>& key_frame);
  bool is_due(bool last) const;

  KeyFrames recent_;           ///< of the newest sub-map
  ResidualVariance variance_;  ///< of its last key frames, the latest weigh most
  int key_frames_ = 0;         ///< seen in the dive
  int fitted_at_ = 0;          ///< so many were seen at the last attempt
  int attempts_ = 0;
  bool alerted_ = false;
};

}  // namespace nadir::odometry
