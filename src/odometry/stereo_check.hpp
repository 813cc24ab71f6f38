// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether the two images of a pair belong together as the calibration says.
#pragma once

#include "features.hpp"
#include "mapping.hpp"

namespace nadir::odometry {

/// Swapped images, images of different moments and another rig's calibration make a map that looks
/// metric and is not. The first pairs with enough corners in common decide; later key frames whose
/// tie points are not found in the right image, two in a row, end the pair.
class StereoCheck {
 public:
  /// The frame itself; as that of a single camera when its pair is refused. An alert when this one
  /// decides so.
  std::shared_ptr<const Frame> passed(const View& pair, std::vector<Alert>& alerts);

  /// What a key frame's right image shows; an alert when it decides against the pair.
  void observe(const Frame& pair, const InRight& right, std::vector<Alert>& alerts);

 private:
  std::shared_ptr<const Frame> without_right(const Frame& pair);

  int agreeing_ = 0, contradicting_ = 0;
  int foreign_ = 0;                                  ///< key frames in a row
  std::shared_ptr<const CameraRig> rig_, left_rig_;  ///< a pair's, and the same without its right
};

}  // namespace nadir::odometry
