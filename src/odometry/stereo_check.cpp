// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_check.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "resection.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

constexpr int kPairs = 2;            // that must say the same
constexpr int kMinMatches = 40;      // of a pair that says anything
constexpr int kMinCorners = 60;      // of an image that is not blank
constexpr double kTolerance_px = 3;  // corners are good to 0.6 px, a doubtful calibration to more
constexpr double kMinShare = 0.5;    // of the matches, in front of both cameras and on their lines

// Correspondences found without the calibration, and how many of them it allows.
struct Count {
  int matches = 0, allowed = 0;
  bool right_blank = false;
};

Count count(const View& pair) {
  const CameraRig& rig = *pair.frame->rig;
  const CameraModel& camera = rig.right->camera;
  const Features right = detect_features(pair.frame->right, camera, pair.features.size());
  const auto matched = correspond(pair.features, right, camera);
  Count count;
  count.right_blank = right.size() < kMinCorners;
  for (const auto& [i, k] : matched.pairs) {
    ++count.matches;
    const Eigen::Vector2d& a = pair.features.rays[static_cast<std::size_t>(i)];
    const Eigen::Vector2d& b = right.rays[static_cast<std::size_t>(k)];
    const std::array<Bearing, 2> bearings{{{{}, a}, {rig.right->right_from_left, b}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    const auto again = ray_of(*x), other = ray_of(rig.right->right_from_left * *x);
    if (again && other && (*again - a).norm() * rig.left.fx < kTolerance_px &&
        (*other - b).norm() * camera.fx < kTolerance_px) {
      ++count.allowed;
    }
  }
  return count;
}

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
    const auto [matches, allowed, right_blank] = count(pair);
    if (right_blank && ++contradicting_ == kPairs) alerts.push_back(blank_right(frame));
    if (!right_blank && matches >= kMinMatches) {
      ++(allowed >= kMinShare * matches ? agreeing_ : contradicting_);
      if (contradicting_ == kPairs) alerts.push_back(suspicion(frame, matches, allowed));
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
