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

using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;

// A vehicle that rolls, pitches and holds its heading to some degrees, as images at 2 Hz see it;
// its noisy AHRS tells what `as_told` makes of the truth.
struct Vehicle {
  double pitch_deg = 0;
  AttitudeSigma sigma;
  std::function<double(int)> heading = [](int) { return 80 * kDegree; };
  std::function<Quaterniond(int)> map_bends = [](int) { return Quaterniond::Identity(); };
  double moves = 1;
  double noise_deg = 0.4;

  std::vector<AttitudeContradiction> contradictions(
      const std::function<Attitude(Attitude, int)>& as_told, int images = 60) const {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, noise_deg * kDegree);
    AttitudeCheck check(sigma);
    std::vector<AttitudeContradiction> told;
    for (int i = 0; i < images; ++i) {
      const Attitude truth{moves * 3 * kDegree * std::sin(0.5 * i),
                           pitch_deg * kDegree + moves * 2.5 * kDegree * std::sin(0.37 * i + 1),
                           heading(i) + moves * 4 * kDegree * std::sin(0.21 * i)};
      const Attitude ahrs = as_told(
          {truth.roll + noise(random), truth.pitch + noise(random), truth.yaw + noise(random)}, i);
      const AttitudeSample sample{from_seconds(0.5 * i), 0, map_bends(i) * truth.ned_from_body(),
                                  ahrs.ned_from_body()};
      if (auto contradiction = check.observe(sample)) told.push_back(*contradiction);
    }
    return told;
  }
};

std::vector<AttitudeContradiction> contradictions(
    const std::function<Attitude(Attitude, int)>& as_told, int images = 60) {
  return Vehicle{}.contradictions(as_told, images);
}

Attitude as_it_is(Attitude a, int) { return a; }

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

TEST(AttitudeCheck, ErrorOfTheHeadingOfATiltedVehicleIsNoneOfItsTilt) {
  for (const double pitch : {-30, -15, 10, 15, 30}) {
    Vehicle vehicle;
    vehicle.pitch_deg = pitch;
    const auto jump = vehicle.contradictions([](Attitude a, int i) {
      if (i >= 20) a.yaw += 45 * kDegree;
      return a;
    });
    ASSERT_EQ(jump.size(), 1u) << pitch;
    EXPECT_FALSE(jump[0].of_tilt) << pitch << ": " << jump[0].message;
    EXPECT_THAT(jump[0].message, HasSubstr("over the last 2.5 s it turned by"));
    EXPECT_THAT(jump[0].message, HasSubstr("in heading"));

    const auto sign = vehicle.contradictions([](Attitude a, int) {
      a.yaw = -a.yaw;
      return a;
    });
    ASSERT_EQ(sign.size(), 1u) << pitch;
    EXPECT_FALSE(sign[0].of_tilt) << pitch << ": " << sign[0].message;
    EXPECT_THAT(sign[0].message, HasSubstr("in heading it turns by -"));
  }
}

TEST(AttitudeCheck, TiltedVehicleThatAgreesIsLeftAlone) {
  for (const double pitch : {-30, 15, 30, 60}) {
    Vehicle vehicle;
    vehicle.pitch_deg = pitch;
    EXPECT_TRUE(vehicle.contradictions(as_it_is, 500).empty()) << pitch;
  }
}

TEST(AttitudeCheck, TurningBackIsNoWrongSign) {
  Vehicle vehicle;
  vehicle.moves = 0.1;
  vehicle.heading = [](int i) { return std::floor(i / 20.0) * 179 * kDegree; };
  for (const double pitch : {0, 15}) {
    vehicle.pitch_deg = pitch;
    const auto told = vehicle.contradictions(
        [](Attitude a, int i) {
          a.yaw += std::floor(i / 20.0) * 2 * kDegree;
          return a;
        },
        400);
    EXPECT_TRUE(told.empty()) << told[0].message;
  }
}

TEST(AttitudeCheck, MapThatBendsIsNoFaultOfTheAhrs) {
  Vehicle vehicle;
  vehicle.noise_deg = 0.2;
  vehicle.map_bends = [](int i) {
    return Quaterniond(AngleAxisd(
        0.35 * kDegree * i, Attitude{0, 0, 80 * kDegree}.ned_from_body() * Vector3d::UnitY()));
  };
  for (const double moves : {0.1, 0.3, 1.0}) {
    vehicle.moves = moves;
    const auto told = vehicle.contradictions(as_it_is, 120);
    EXPECT_TRUE(told.empty()) << moves << ": " << told[0].message;
  }
}

TEST(AttitudeCheck, ImagesHaveAnErrorOfTheirOwn) {
  Vehicle vehicle;
  vehicle.sigma = {0.1, 0.1};
  vehicle.map_bends = [](int i) {
    return Quaterniond(AngleAxisd(1 * kDegree * std::sin(0.3 * i), Vector3d::UnitX()));
  };
  const auto told = vehicle.contradictions(as_it_is, 400);
  EXPECT_TRUE(told.empty()) << told[0].message;
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
    const Attitude in_submap{0, 0, 2.0 * std::floor(i / 10.0)};
    EXPECT_FALSE(check.observe({from_seconds(0.5 * i), static_cast<std::uint32_t>(i / 10),
                                in_submap.ned_from_body(), Attitude{}.ned_from_body()}));
  }
}

}  // namespace
}  // namespace nadir::reference
