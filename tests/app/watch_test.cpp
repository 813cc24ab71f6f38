// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "watch.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

/// A stage watched every second.
class WatchTest : public testing::Test {
 protected:
  /// cpu: used of the next second; busy: with an item in hand since that long.
  std::optional<std::string> after_a_second(double cpu,
                                            std::optional<std::chrono::nanoseconds> busy,
                                            const std::string& stage = "stage") {
    now += 1s;
    cpu_s += cpu;
    return watch.hung(now, {{.stage = "idle"}, {.stage = stage, .busy = busy, .cpu_s = cpu_s}});
  }

  Watch watch;
  Watch::Clock::time_point now;
  double cpu_s = 100;
};

TEST_F(WatchTest, FindsAStageThatSleepsWithAnItemInHand) {
  for (int s = 1; s <= 4; ++s) EXPECT_FALSE(after_a_second(0, 1s * s)) << s;
  EXPECT_EQ(after_a_second(0, 5s), "stage");
}

TEST_F(WatchTest, BearsASlowCard) {
  for (int s = 1; s <= 6; ++s) EXPECT_FALSE(after_a_second(0, 1s * s, "record")) << s;
  EXPECT_EQ(after_a_second(0, 7s, "record"), "record");
}

TEST_F(WatchTest, LetsAStageWorkForAMinute) {
  for (int s = 1; s < 60; ++s) EXPECT_FALSE(after_a_second(0.3, 1s * s)) << s;
  EXPECT_EQ(after_a_second(0.3, 60s), "stage");
}

TEST_F(WatchTest, FindsAStageThatStopsWorkingInTheMiddle) {
  for (int s = 1; s <= 10; ++s) EXPECT_FALSE(after_a_second(1, 1s * s)) << s;
  int until = 11;
  while (!after_a_second(0, 1s * until)) ++until;
  EXPECT_LE(until, 18);
}

TEST_F(WatchTest, IsNotMisledByManyItemsThatWaitABit) {
  for (int s = 1; s <= 100; ++s) EXPECT_FALSE(after_a_second(0, s % 2 == 0 ? 900ms : 100ms)) << s;
}

TEST_F(WatchTest, FindsAStageThatTakesNothingOfWhatWaits) {
  const auto found = [&](bool neglects, std::uint64_t processed) {
    now += 1s;
    return watch.hung(now,
                      {{.stage = "stage", .neglects_input = neglects, .processed = processed}});
  };
  for (std::uint64_t s = 0; s < 20; ++s) EXPECT_FALSE(found(true, s)) << s;  // it goes on
  for (int s = 0; s < 3; ++s) EXPECT_FALSE(found(true, 19)) << s;
  EXPECT_FALSE(found(false, 19));
  for (int s = 0; s < 3; ++s) EXPECT_FALSE(found(true, 19)) << s;
  EXPECT_EQ(found(true, 19), "stage");
}

TEST_F(WatchTest, DoesNotBlameAStageThatGetsNoProcessor) {
  for (int s = 1; s < 60; ++s) {
    now += 1s;
    const auto found =
        watch.hung(now, {{.stage = "stage", .busy = 1s * s, .cpu_s = 1, .wants_to_run = true}});
    EXPECT_FALSE(found) << s;
  }
}

TEST_F(WatchTest, LetsAStageWaitForever) {
  for (int s = 1; s <= 100; ++s) EXPECT_FALSE(after_a_second(0, std::nullopt)) << s;
}

}  // namespace
}  // namespace nadir::app
