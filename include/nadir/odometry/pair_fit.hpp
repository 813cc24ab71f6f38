// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How well the two images of a pair fit their calibration, by corners found in both without it.
#pragma once

#include "nadir/core/frame.hpp"
#include "nadir/core/key_frame.hpp"

namespace nadir::odometry {

/// Fewer corners in common say nothing.
constexpr int kEnoughMatches = 40;

struct PairFit {
  int matches = 0;
  int allowed = 0;         ///< within a few pixels of what one point before both cameras shows
  double epipolar_px = 0;  ///< median distance from the epipolar lines in the right image
  bool right_blank = false;
};

/// left: corners of the left image. The frame has a right image and its rig a right camera.
PairFit pair_fit(const Frame& pair, const Features& left);
/// The same; finds them first, which takes a tenth of a second or more.
PairFit pair_fit(const Frame& pair);

}  // namespace nadir::odometry
