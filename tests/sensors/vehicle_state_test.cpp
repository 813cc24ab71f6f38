// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/vehicle_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nadir/core/check.hpp"

namespace nadir::sensors {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kExact = 1e-9;

Time at(double s) { return from_seconds(s); }

Reading tilt(double roll, double pitch) {
  Reading reading;
  reading.roll = roll;
  reading.pitch = pitch;
  return reading;
}
Reading heading(double value) {
  Reading reading;
  reading.heading = value;
  return reading;
}
Reading depth(double value) {
  Reading reading;
  reading.depth = value;
  return reading;
}

Frame marked(const VehicleState& state, double s) {
  Frame frame;
  frame.time = at(s);
  state.mark(frame);
  return frame;
}

VehicleState state_of(const Config& config = {}) { return {config, {"ahrs", "autopilot"}}; }

TEST(VehicleState, PutsTogetherWhatSentencesTellApart) {
  VehicleState state = state_of();
  state.hear(0, at(1.0), tilt(0.1, -0.2));
  state.hear(0, at(1.1), heading(6.2));
  EXPECT_FALSE(marked(state, 1.05).attitude);  // no heading yet
  state.hear(0, at(1.2), tilt(0.2, -0.2));
  state.hear(0, at(1.3), heading(0.1));
  state.hear(1, at(1.3), depth(12));
  const Frame frame = marked(state, 1.2);
  ASSERT_TRUE(frame.attitude);
  EXPECT_NEAR(frame.attitude->roll, 0.2, kExact);
  const double half = std::remainder(0.1 - 6.2, 2 * std::numbers::pi) / 2;
  EXPECT_NEAR(std::remainder(frame.attitude->yaw - (6.2 + half), 2 * std::numbers::pi), 0, kExact);
  EXPECT_FALSE(frame.depth);
  EXPECT_DOUBLE_EQ(marked(state, 1.35).depth.value(), 12);  // the newest, for a moment
  EXPECT_FALSE(marked(state, 1.45).depth);
}

TEST(VehicleState, ValuesWereTrueBeforeTheyArrived) {
  Config config;
  config.depth_delay_s = 0.2;
  VehicleState state = state_of(config);
  for (int i = 0; i < 10; ++i) state.hear(0, at(0.1 * i + 0.2), depth(i));
  EXPECT_NEAR(marked(state, 0.5).depth.value(), 5, kExact);
}

// What a sensor stamps itself arrives late by up to 80 ms, and lies where it was measured. The
// least late come each half second, by when a crystal may have drifted by 50 us.
TEST(VehicleState, StampsOfTheSensorTakeOutTheJitterOfItsWay) {
  VehicleState state = state_of();
  for (int i = 0; i < 100; ++i) {
    Reading reading = depth(std::sin(0.1 * i));
    reading.uptime = at(1000 + 0.1 * i);
    const double late = 0.02 * (i * 7 % 5);
    state.hear(1, at(50 + 0.1 * i + late), reading);
  }
  for (int i = 10; i < 95; ++i)
    EXPECT_NEAR(marked(state, 50 + 0.1 * i).depth.value(), std::sin(0.1 * i), 6e-5) << i;
}

TEST(VehicleState, ASensorThatStartedAgainIsBelievedAgain) {
  VehicleState state = state_of();
  for (int i = 0; i < 40; ++i) {
    Reading reading = depth(i);
    reading.uptime = i < 20 ? at(500 + 0.1 * i) : at(0.1 * (i - 20));
    state.hear(0, at(0.1 * i), reading);
  }
  EXPECT_NEAR(marked(state, 3.5).depth.value(), 35, 1e-3);
}

TEST(VehicleState, MagneticHeadingsBecomeTrueByTheVariation) {
  Config config;
  config.magnetic_variation_deg = 3;
  VehicleState state = state_of(config);
  Reading magnetic;
  magnetic.magnetic_heading = 359 * kDegree;
  state.hear(0, at(0), tilt(0, 0));
  state.hear(0, at(0), magnetic);
  EXPECT_NEAR(marked(state, 0).attitude->yaw, 2 * kDegree, kExact);
  magnetic.variation = -2 * kDegree;  // told by the sensor
  state.hear(0, at(0.1), tilt(0, 0));
  state.hear(0, at(0.1), magnetic);
  EXPECT_NEAR(
      std::remainder(marked(state, 0.1).attitude->yaw - 357 * kDegree, 2 * std::numbers::pi), 0,
      kExact);
}

TEST(VehicleState, PressureBecomesDepth) {
  Config config;
  config.surface_pressure_hpa = 1000;
  config.water_density = 1000;
  VehicleState state = state_of(config);
  Reading reading;
  reading.pressure = 1e5 + 9806.65 * 12.5;
  state.hear(0, at(0), reading);
  EXPECT_NEAR(marked(state, 0).depth.value(), 12.5, 1e-9);
}

TEST(VehicleState, KeepsToOneSourceUntilItIsSilent) {
  VehicleState state = state_of();
  for (int i = 0; i < 40; ++i) {
    if (i < 10) state.hear(0, at(0.1 * i), depth(5));
    state.hear(1, at(0.1 * i + 0.01), depth(6));
  }
  EXPECT_DOUBLE_EQ(marked(state, 3.5).depth.value(), 6);
  EXPECT_FALSE(marked(state, 0.85).depth);  // nothing is interpolated between two sensors
  VehicleState early = state_of();
  early.hear(0, at(0), depth(5));
  early.hear(1, at(0.01), depth(6));
  EXPECT_DOUBLE_EQ(marked(early, 0.05).depth.value(), 5);
}

TEST(VehicleState, SendersOfOneInputAreNotMixed) {
  VehicleState state = state_of();
  for (int i = 0; i < 30; ++i) {
    Reading outside = depth(5), inside = depth(0);
    outside.sender = 1;
    inside.sender = 2;
    state.hear(0, at(0.1 * i), outside);
    state.hear(0, at(0.1 * i + 0.05), inside);
  }
  for (int i = 1; i < 28; ++i) EXPECT_DOUBLE_EQ(marked(state, 0.1 * i + 0.03).depth.value(), 5);
}

TEST(VehicleState, WhatIsToldOutrightGoesBeforeWhatIsWorkedOut) {
  VehicleState state = state_of();
  for (int i = 0; i < 10; ++i) {
    Reading pressure;
    pressure.pressure = 2e5;
    state.hear(0, at(0.1 * i), pressure);
    if (i > 4) state.hear(0, at(0.1 * i + 0.01), depth(7));
  }
  EXPECT_DOUBLE_EQ(marked(state, 0.8).depth.value(), 7);
}

TEST(VehicleState, AStalledLinkShiftsNoTimes) {
  VehicleState state = state_of();
  for (int i = 0; i < 60; ++i) {
    Reading reading = depth(0.1 * i);
    reading.uptime = at(100 + 0.1 * i);
    const bool stalled = i >= 20 && i < 35;
    state.hear(0, stalled ? at(3.5 + 0.001 * i) : at(0.1 * i), reading);
  }
  for (int i = 1; i < 58; ++i) EXPECT_NEAR(marked(state, 0.1 * i).depth.value(), 0.1 * i, 1e-3);
}

TEST(VehicleState, SaysWhichSensorStandsInForASilentOne) {
  VehicleState state = state_of();
  std::vector<Alert> told;
  for (int i = 0; i < 60; ++i) {
    if (i < 20) state.hear(0, at(0.1 * i), depth(5));
    state.hear(1, at(0.1 * i), depth(5));
    for (const Alert& alert : state.new_alerts(at(0.1 * i), {})) told.push_back(alert);
  }
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("ahrs: depth was not heard"), std::string::npos);
  EXPECT_NE(told[0].message.find("autopilot stands in"), std::string::npos);
}

TEST(VehicleState, TellsOfASilentSensorOnceAndAgainAfterItWasGood) {
  VehicleState state = state_of();
  int told = 0;
  const auto live = [&](double from, double to, bool speaks) {
    for (double s = from; s < to; s += 0.1) {
      if (speaks) state.hear(0, at(s), depth(3));
      for (const Alert& alert : state.new_alerts(at(s), 7)) {
        ++told;
        EXPECT_EQ(alert.kind, AlertKind::sensor_stale);
        EXPECT_NE(alert.message.find("ahrs: depth was not heard"), std::string::npos);
        EXPECT_EQ(alert.image, 7u);
      }
    }
  };
  live(0, 5, true);
  EXPECT_EQ(told, 0);
  live(5, 10, false);
  EXPECT_EQ(told, 1);
  live(10, 15, true);
  live(15, 20, false);
  EXPECT_EQ(told, 1);  // it comes and goes
  live(20, 35, true);
  live(35, 40, false);
  EXPECT_EQ(told, 2);
}

TEST(VehicleState, LeavesOutJumpsAndSaysSo) {
  VehicleState state = state_of();
  for (int i = 0; i < 20; ++i) state.hear(0, at(0.1 * i), depth(i == 10 ? 60 : 3));
  EXPECT_NEAR(marked(state, 1.0).depth.value(), 3, kExact);
  const auto alerts = state.new_alerts(at(2), {});
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_NE(alerts[0].message.find("depth jumped"), std::string::npos);
  EXPECT_TRUE(state.new_alerts(at(2.1), {}).empty());
}

TEST(VehicleState, BelievesNoneOfValuesThatJumpAbout) {
  VehicleState state = state_of();
  for (int i = 0; i < 20; ++i) {
    const bool wild = i >= 8 && i < 12;
    state.hear(0, at(0.1 * i), depth(wild ? 60.0 * (i % 2) - 20 * i : 3));
  }
  EXPECT_NEAR(marked(state, 1.0).depth.value(), 3, kExact);
  EXPECT_NEAR(marked(state, 1.5).depth.value(), 3, kExact);
}

TEST(VehicleState, BelievesWhatStaysWhereItJumpedTo) {
  VehicleState state = state_of();
  for (int i = 0; i < 20; ++i) state.hear(0, at(0.1 * i), depth(i < 10 ? 60 : 3));
  EXPECT_NEAR(marked(state, 1.8).depth.value(), 3, kExact);
  EXPECT_FALSE(marked(state, 0.95).depth);
}

// Each third comes with the least delay; meanwhile crystals may have drifted by 0.3 ms.
TEST(VehicleState, KnowsTheUtcByTheLeastDelayedTime) {
  VehicleState state = state_of();
  EXPECT_FALSE(state.utc_offset());
  for (int i = 0; i < 20; ++i) {
    Reading reading;
    reading.utc = at(1e9 + i);
    state.hear(0, at(i + 0.05 + 0.1 * (i % 3)), reading);
  }
  EXPECT_NEAR(seconds(*state.utc_offset()), 1e9 - 0.05, 3.1e-4);
}

TEST(VehicleStateConfig, NamesWhatIsOutOfRange) {
  const auto refused = [](auto change) {
    Config config;
    change(config);
    try {
      config.check();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused([](Config& c) { c.attitude_delay_s = -1; }).find("sensors.attitude_delay_s"),
            std::string::npos);
  EXPECT_NE(refused([](Config& c) { c.water_density = 1; }).find("sensors.water_density"),
            std::string::npos);
  EXPECT_NE(refused([](Config& c) { c.inputs = "nmea:udp:x"; }).find("no port"), std::string::npos);
  EXPECT_EQ(refused([](Config&) {}), "");
}

}  // namespace
}  // namespace nadir::sensors
