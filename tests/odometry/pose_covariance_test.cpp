// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kNoise_px = 0.2;

// Four images along a strip, seen by a pair; the first is fixed.
Adjustment strip(const CameraRig& rig, std::mt19937& random, std::vector<Rigid3>& truth) {
  std::normal_distribution<double> noise(0, kNoise_px);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  Adjustment a;
  truth.clear();
  for (int i = 0; i < 4; ++i) {
    truth.push_back(looking_down(0.3 * i, 0.02 * i, 1.5, 0.05 * i).inverse());
    a.images.push_back({truth.back(), i == 0, false});
  }
  for (int k = 0; k < 150; ++k) {
    const Vector3d x(0.5 + 1.2 * anywhere(random), 0.6 * anywhere(random), 0.1 * anywhere(random));
    const int point = static_cast<int>(a.points.size());
    a.points.push_back({x, false});
    for (int i = 0; i < 4; ++i) {
      const Vector3d in_left = truth[static_cast<std::size_t>(i)] * x;
      const auto seen = [&](const Vector3d& in_camera, const CameraModel& camera, bool right) {
        const auto pixel = camera.project(in_camera);
        if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > camera.width ||
            pixel->y() > camera.height)
          return;
        const Vector2d error(noise(random) / camera.fx, noise(random) / camera.fx);
        a.observations.push_back({i, point, right, in_camera.hnormalized() + error});
      };
      seen(in_left, rig.left, false);
      seen(rig.right->right_from_left * in_left, rig.right->camera, true);
    }
  }
  return a;
}

// The stated sigma against what happens: a ratio of variances of 3 x 60 normal values lies within
// 1 +- 4 sqrt(2 / 180).
TEST(PoseCovariance, IsWhatTheErrorsOfManyAdjustmentsShow) {
  constexpr int kTrials = 60;
  const CameraRig rig = small_pair();
  std::mt19937 random(3);
  double turns = 0, shifts = 0, stated_turns = 0, stated_shifts = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Rigid3> truth;
    Adjustment a = strip(rig, random, truth);
    ASSERT_TRUE(adjust(a, rig, {1.0, 30, 1e-5}).usable);
    const auto covariance = PoseCovariance::of(a, rig, 1.0);
    ASSERT_TRUE(covariance);
    const auto relative = covariance->relative(a, 2, 3);
    stated_turns += relative.topLeftCorner<3, 3>().trace();
    stated_shifts += relative.bottomRightCorner<3, 3>().trace();
    const Rigid3 found = a.images[3].camera_from_map * a.images[2].camera_from_map.inverse();
    const Rigid3 error = found * (truth[3] * truth[2].inverse()).inverse();
    turns += std::pow(error.rotation.angularDistance(Eigen::Quaterniond::Identity()), 2);
    shifts += error.translation.squaredNorm();
  }
  const double tolerance = 4 * std::sqrt(2.0 / (3 * kTrials));
  EXPECT_NEAR(turns / stated_turns, 1, tolerance);
  EXPECT_NEAR(shifts / stated_shifts, 1, tolerance);
}

TEST(PoseCovariance, IsNoneWhenNothingHoldsTheMap) {
  const CameraRig rig = small_pair();
  std::mt19937 random(3);
  std::vector<Rigid3> truth;
  Adjustment a = strip(rig, random, truth);
  a.images[0].fixed = false;
  a.observations.resize(4);
  EXPECT_FALSE(PoseCovariance::of(a, rig, 1.0));
}

}  // namespace
}  // namespace nadir::odometry
