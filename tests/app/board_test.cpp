// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "board.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

TEST(DiskForecast, GoesByHowTheDiskFilledOfLate) {
  DiskForecast forecast;
  const DiskForecast::Clock::time_point begin{};
  double free = 10e9;
  for (int second = 0; second < 30; ++second, free -= 2e6)
    EXPECT_EQ(forecast.observe(begin + second * 1s, free), std::nullopt);
  const auto left = forecast.observe(begin + 30s, free);
  ASSERT_TRUE(left);
  EXPECT_NEAR(*left, free / 2e6, 1);
  // Ten times as fast: after the memory of five minutes only that counts.
  std::optional<double> later;
  for (int second = 31; second < 400; ++second, free -= 20e6)
    later = forecast.observe(begin + second * 1s, free);
  ASSERT_TRUE(later);
  EXPECT_NEAR(*later, free / 20e6, 0.05 * free / 20e6);
}

TEST(DiskForecast, IsNoneWhileTheDiskDoesNotFill) {
  DiskForecast forecast;
  for (int second = 0; second < 100; ++second)
    EXPECT_EQ(forecast.observe(DiskForecast::Clock::time_point{} + second * 1s, 1e9 + second),
              std::nullopt);
}

}  // namespace
}  // namespace nadir::app
