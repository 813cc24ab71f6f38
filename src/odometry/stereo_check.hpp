// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether the two images of a pair belong together as the calibration says.
#pragma once

#include "features.hpp"

namespace nadir::odometry {

/// Swapped images, images of different moments and another rig's calibration make a map that looks
/// metric and is not. The first pairs with enough corners in common decide for all that follow.
class StereoCheck {
 public:
  /// The frame itself; as that of a single camera when its pair is refused. An alert when this one
  /// decides so.
  std::shared_ptr<const Frame> passed(const View& pair, std::vector<Alert>& alerts);

 private:
  std::shared_ptr<const Frame> without_right(const Frame& pair);

  int agreeing_ = 0, contradicting_ = 0;
  std::shared_ptr<const CameraRig> rig_, left_rig_;  ///< a pair's, and the same without its right
};

}  // namespace nadir::odometry
