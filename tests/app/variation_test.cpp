// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "variation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace nadir::app {
namespace {

constexpr Time kJune2026 = 1'780'272'000'000'000'000, k2033 = 1'988'150'400'000'000'000;

Config off_marseille() {
  Config config;
  config.sensors.inputs = "nmea:udp:10110";
  config.reference.origin = "43.296 5.37";
  return config;
}

TEST(Variation, IsThatOfTheOriginAndTheDay) {
  const auto found = variation_by_model(off_marseille(), kJune2026);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->degrees, 2.78, 0.02);
  EXPECT_FALSE(found->alert);
}

TEST(Variation, IsNotAskedForWithoutAnOriginOrSensorsOrWhenItIsSet) {
  Config config = off_marseille();
  config.reference.origin = "";
  EXPECT_FALSE(variation_by_model(config, kJune2026));
  config = off_marseille();
  config.sensors.inputs = "";
  EXPECT_FALSE(variation_by_model(config, kJune2026));
  config = off_marseille();
  config.sensors.magnetic_variation_deg = -1;
  EXPECT_FALSE(variation_by_model(config, kJune2026));
}

TEST(Variation, ByAClockThatCannotBeRightIsTold) {
  const auto unset = variation_by_model(off_marseille(), 0);
  ASSERT_TRUE(unset && unset->alert);
  EXPECT_EQ(unset->alert->kind, AlertKind::clock);
  EXPECT_THAT(unset->alert->message, testing::HasSubstr("says 1970"));
  EXPECT_NEAR(unset->degrees, 2.5, 0.3);
  const auto late = variation_by_model(off_marseille(), k2033);
  ASSERT_TRUE(late && late->alert);
  EXPECT_THAT(late->alert->message, testing::HasSubstr("ended with 2029"));
  EXPECT_THAT(late->alert->remedy, testing::HasSubstr("update"));
}

// What the vehicle does with it.
TEST(Variation, MakesAMagneticHeadingTrue) {
  Config config = off_marseille();
  config.sensors.magnetic_variation_deg = variation_by_model(config, kJune2026)->degrees;
  sensors::VehicleState vehicle(config.sensors, {"compass"});
  sensors::Reading reading;
  reading.roll = reading.pitch = 0;
  reading.magnetic_heading = 1;
  vehicle.hear(0, 1'000'000'000, reading);
  Frame frame;
  frame.time = 1'000'000'000;
  vehicle.mark(frame);
  ASSERT_TRUE(frame.attitude);
  EXPECT_NEAR((frame.attitude->yaw - 1) * 180 / std::numbers::pi, 2.78, 0.02);
}

}  // namespace
}  // namespace nadir::app
