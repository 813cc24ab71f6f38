// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_check.hpp"

#include "nadir/odometry/pair_fit.hpp"

namespace nadir::odometry {
namespace {

constexpr int kPairs = 2;          // that must say the same
constexpr double kMinShare = 0.5;  // of the matches, in front of both cameras and on their lines

Alert blank_right(const Frame& frame) {
  return {frame.time, frame.image, AlertKind::calibration_suspect,
          "the right image shows nothing; the left images alone are mapped, unscaled",
          "check the right camera, its cable and its lens"};
}

Alert suspicion(const Frame& frame, int matches, int allowed) {
  return {frame.time, frame.image, AlertKind::calibration_suspect,
          "left and right image do not fit the calibration: of " + std::to_string(matches) +
              " corners seen in both only " + std::to_string(allowed) +
              " agree with it; the left images alone are mapped, unscaled",
          "check that left and right are not swapped and of the same moment, and that the "
          "calibration is of this pair, made under water"};
}

}  // namespace

std::shared_ptr<const Frame> StereoCheck::passed(const View& pair, std::vector<Alert>& alerts) {
  const Frame& frame = *pair.frame;
  if (!frame.rig->right || frame.right.empty() || agreeing_ == kPairs) return pair.frame;
  if (contradicting_ < kPairs && !is_blank(pair)) {
    const PairFit fit = pair_fit(frame, pair.features);
    if (fit.right_blank && ++contradicting_ == kPairs) alerts.push_back(blank_right(frame));
    if (!fit.right_blank && fit.matches >= kEnoughMatches) {
      ++(fit.allowed >= kMinShare * fit.matches ? agreeing_ : contradicting_);
      if (contradicting_ == kPairs) alerts.push_back(suspicion(frame, fit.matches, fit.allowed));
    }
  }
  return contradicting_ > agreeing_ ? without_right(frame) : pair.frame;
}

void StereoCheck::observe(const Frame& pair, const InRight& right, std::vector<Alert>& alerts) {
  if (right.looked_for == 0) return;
  foreign_ = is_foreign(right) ? foreign_ + 1 : 0;
  if (foreign_ < kPairs || contradicting_ > agreeing_) return;
  agreeing_ = 0;
  contradicting_ = kPairs;
  alerts.push_back({pair.time, pair.image, AlertKind::calibration_suspect,
                    "the right image no longer fits the left: of " +
                        std::to_string(right.looked_for) + " tie points only " +
                        std::to_string(right.found) +
                        " are found in it; the left images alone are mapped on",
                    "check that the right camera delivers images, of the same moment, and that "
                    "neither camera was moved against the other"});
}

std::shared_ptr<const Frame> StereoCheck::without_right(const Frame& pair) {
  if (rig_ != pair.rig) {
    rig_ = pair.rig;
    auto left = std::make_shared<CameraRig>(*pair.rig);
    left->right.reset();
    left_rig_ = std::move(left);
  }
  auto frame = std::make_shared<Frame>(pair);
  frame->rig = left_rig_;
  frame->right.release();
  return frame;
}

}  // namespace nadir::odometry
