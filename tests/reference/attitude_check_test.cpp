// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/attitude_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "nadir/core/frame.hpp"

namespace nadir::reference {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

// A vehicle that rolls, pitches and holds its heading to some degrees, as images at 2 Hz see it;
// its AHRS, of 0.4 degrees of noise, tells what `as_told` makes of the truth.
std::vector<AttitudeContradiction> contradictions(
    const std::function<Attitude(Attitude, int)>& as_told, int images = 60) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.4 * kDegree);
  AttitudeCheck check({});
  std::vector<AttitudeContradiction> told;
  for (int i = 0; i < images; ++i) {
    const Attitude truth{3 * kDegree * std::sin(0.5 * i), 2.5 * kDegree * std::sin(0.37 * i + 1),
                         80 * kDegree + 4 * kDegree * std::sin(0.21 * i)};
    const Attitude ahrs = as_told(
        {truth.roll + noise(random), truth.pitch + noise(random), truth.yaw + noise(random)}, i);
    const AttitudeSample sample{from_seconds(0.5 * i), 0, truth.ned_from_body(),
                                ahrs.ned_from_body()};
    if (auto contradiction = check.observe(sample)) told.push_back(*contradiction);
  }
  return told;
}

TEST(AttitudeCheck, AhrsThatAgreesIsLeftAlone) {
  EXPECT_TRUE(contradictions([](Attitude a, int) { return a; }, 2000).empty());
}

TEST(AttitudeCheck, OffsetsSpikesAndASlowlyWrongHeadingAreNoContradiction) {
  EXPECT_TRUE(contradictions([](Attitude a, int i) {
                a.roll += 4 * kDegree + (i == 30 ? 40 * kDegree : 0);
                a.yaw += 20 * kDegree * std::sin(0.02 * i);
                return a;
              }).empty());
}

TEST(AttitudeCheck, RadiansInDegreesAreNamed) {
  const auto told = contradictions([](Attitude a, int) {
    return Attitude{a.roll * kDegree, a.pitch * kDegree, a.yaw * kDegree};
  });
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(told[0].of_tilt);
  EXPECT_THAT(told[0].message, HasSubstr("turns by 0.0"));
}

TEST(AttitudeCheck, WrongSignsAreNamed) {
  const auto of_roll = contradictions([](Attitude a, int) {
    a.roll = -a.roll;
    return a;
  });
  ASSERT_EQ(of_roll.size(), 1u);
  EXPECT_TRUE(of_roll[0].of_tilt);
  EXPECT_THAT(of_roll[0].message, HasSubstr("in roll it turns by -"));

  const auto of_yaw = contradictions([](Attitude a, int) {
    a.yaw = -a.yaw;
    return a;
  });
  ASSERT_EQ(of_yaw.size(), 1u);
  EXPECT_FALSE(of_yaw[0].of_tilt);
  EXPECT_THAT(of_yaw[0].message, HasSubstr("in heading it turns by -"));
}

TEST(AttitudeCheck, SwappedColumnsAreNamedOnce) {
  const auto told = contradictions([](Attitude a, int) {
    return Attitude{a.pitch, a.roll, a.yaw};
  });
  ASSERT_EQ(told.size(), 1u);
  EXPECT_TRUE(told[0].of_tilt);
}

TEST(AttitudeCheck, JumpThatLastsIsNamed) {
  const auto told = contradictions([](Attitude a, int i) {
    if (i >= 20) a.yaw += 90 * kDegree;
    return a;
  });
  ASSERT_EQ(told.size(), 1u);
  EXPECT_FALSE(told[0].of_tilt);
  EXPECT_THAT(told[0].message, HasSubstr("differ by 9"));
}

TEST(AttitudeCheck, VehicleThatHardlyTurnsSaysNothing) {
  AttitudeCheck check({});
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.3 * kDegree);
  for (int i = 0; i < 200; ++i) {
    const Attitude images{noise(random), noise(random), noise(random)};
    EXPECT_FALSE(check.observe(
        {from_seconds(0.5 * i), 0, images.ned_from_body(), Attitude{}.ned_from_body()}));
  }
}

TEST(AttitudeCheck, TurnsOfDifferentSubmapsAreNotCompared) {
  AttitudeCheck check({});
  for (int i = 0; i < 60; ++i) {
    const Attitude in_submap{0, 0, 2.0 * (i / 10)};
    EXPECT_FALSE(check.observe({from_seconds(0.5 * i), static_cast<std::uint32_t>(i / 10),
                                in_submap.ned_from_body(), Attitude{}.ned_from_body()}));
  }
}

}  // namespace
}  // namespace nadir::reference
