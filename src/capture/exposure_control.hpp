// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Steers exposure and gain for tie points: bright enough, and sharp at the speed of now.
#pragma once

#include <optional>

namespace nadir::capture {

/// What a camera can be set to, and how soon.
struct ExposureRange {
  double shortest_ms = 0, longest_ms = 0;
  double least_gain = 0, most_gain = 0;  ///< in the camera's unit, brighter upwards; equal: none
  int delay = 4;                         ///< images from a setting to its effect
};

struct Exposure {
  double ms = 0, gain = 0;
  bool operator==(const Exposure&) const = default;
};

/// Cameras show a new exposure some images later and do not tell what a step of gain means, so the
/// next step waits for the effect of the last and gain is approached in steps. Noise by gain costs
/// fewer tie points than blur does: gain rises only when the exposure is as long as motion and
/// frame rate allow, and falls first.
class ExposureControl {
 public:
  /// max_blur_px: that motion may smear; begin: as the camera is set now.
  ExposureControl(const ExposureRange& range, double max_blur_px, const Exposure& begin);

  /// Of each image its mean grey level, 0 to 255, the speed of the ground in it, px a second (0:
  /// unknown), and the time between images. What the camera is to be set to, when that changes.
  std::optional<Exposure> observe(double mean_grey, double speed_px, double period_ms);

  const Exposure& exposure() const { return exposure_; }

 private:
  double longest_ms(double speed_px, double period_ms) const;

  ExposureRange range_;
  double max_blur_px_;
  Exposure exposure_;
  int settling_ = 0;  ///< images until the last step shows
};

}  // namespace nadir::capture
