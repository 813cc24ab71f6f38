// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "relative_orientation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kFocal = 300;
constexpr double kSigma = 0.5 / kFocal;

struct Pair {
  Rays first, second;
};

// 150 points within `relief` of the ground, with half a pixel of noise, some of them wrong.
Pair pair(const Rigid3& second_from_first, double relief, int wrong = 0) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, kSigma);
  Pair p;
  for (int i = 0; i < 150; ++i) {
    const Vector3d x(0.5 * uniform(random), 0.4 * uniform(random), 1 + relief * uniform(random));
    const Vector3d y = second_from_first * x;
    p.first.emplace_back(x.hnormalized() + Vector2d(noise(random), noise(random)));
    p.second.emplace_back(y.hnormalized() + Vector2d(noise(random), noise(random)));
    if (i < wrong) p.second.back() = {0.5 * uniform(random), 0.4 * uniform(random)};
  }
  return p;
}

Rigid3 step(double length) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(0.1, 0.05, 1).normalized())),
          length * Vector3d(-1, 0.2, 0.1).normalized()};
}

// Half a pixel (1.7 mrad) over 70 to 150 points; tilt and sideways motion look alike but for a
// factor of some 10 to 20 in the images' narrow field.
bool is_near(const RelativeOrientation& o, const Rigid3& truth) {
  return o.second_from_first.rotation.angularDistance(truth.rotation) < 0.02 &&
         (o.second_from_first.translation - truth.translation.normalized()).norm() < 0.06;
}

TEST(RelativeOrientation, IsFoundOverRelief) {
  const Pair p = pair(step(0.4), 0.2);
  const auto found = relative_orientations(p.first, p.second, small_rig().left, kSigma);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(is_near(found.front(), step(0.4)));
  EXPECT_GT(found.front().inliers, 135);
}

TEST(RelativeOrientation, IsAmongTheAnswersOverFlatGround) {
  const Pair p = pair(step(0.4), 0);
  const auto found = relative_orientations(p.first, p.second, small_rig().left, kSigma);
  EXPECT_TRUE(
      std::any_of(found.begin(), found.end(), [](const auto& o) { return is_near(o, step(0.4)); }));
}

TEST(RelativeOrientation, SurvivesWrongMatches) {
  const Pair p = pair(step(0.4), 0.2, 60);
  const Agreement agreement = verify(p.first, p.second, kSigma);
  EXPECT_GE(agreement.inliers.size(), 70U);
  Pair kept;
  for (const int i : agreement.inliers) {
    kept.first.push_back(p.first[static_cast<std::size_t>(i)]);
    kept.second.push_back(p.second[static_cast<std::size_t>(i)]);
  }
  const auto found = relative_orientations(kept.first, kept.second, small_rig().left, kSigma);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(is_near(found.front(), step(0.4)));
}

TEST(Verify, FindsTheHomographyOfFlatGround) {
  const int wrong = 60;
  const Pair p = pair(step(0.4), 0, wrong);
  const Agreement agreement = verify(p.first, p.second, kSigma);
  EXPECT_GE(agreement.inliers.size(), 88U);  // of 90 with errors of 2 x 2 coordinates
  for (std::size_t i = wrong; i < p.first.size(); ++i) {
    const Vector2d mapped = (agreement.homography * p.first[i].homogeneous()).hnormalized();
    EXPECT_LT((mapped - p.second[i]).norm(), 6 * kSigma) << i;
  }
}

TEST(Verify, FindsNothingInUnrelatedMatches) {
  const Pair p = pair(step(0.4), 0.2, 150);
  const Agreement agreement = verify(p.first, p.second, kSigma);
  EXPECT_LT(agreement.inliers.size(), 25U);
}

TEST(RelativeOrientation, HasNoAnswerForAPureRotation) {
  const Pair p = pair(step(0), 0.2);
  EXPECT_TRUE(relative_orientations(p.first, p.second, small_rig().left, kSigma).empty());
}

TEST(RelativeOrientation, HasNoAnswerForTheSameImageTwice) {
  Pair p = pair({}, 0.2);
  p.second = p.first;
  EXPECT_TRUE(relative_orientations(p.first, p.second, small_rig().left, kSigma).empty());
}

TEST(RelativeOrientation, IsFiniteForPointsOnALine) {
  Pair p;
  for (int i = 0; i < 40; ++i) {
    const Vector3d x(0.02 * (i - 20), 0, 1);
    p.first.emplace_back(x.hnormalized());
    p.second.emplace_back((step(0.4) * x).hnormalized());
  }
  for (const auto& o : relative_orientations(p.first, p.second, small_rig().left, kSigma)) {
    EXPECT_TRUE(o.second_from_first.is_finite());
  }
}

TEST(RelativeOrientation, HasNoAnswerForTooFewPoints) {
  const Rays few(5, Vector2d(0.1, 0.1));
  EXPECT_TRUE(verify(few, few, kSigma).inliers.empty());
  EXPECT_TRUE(relative_orientations(few, few, small_rig().left, kSigma).empty());
}

}  // namespace
}  // namespace nadir::odometry
