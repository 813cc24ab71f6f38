// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "drop_rate.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

StageStats stage(const char* name, std::uint64_t processed, std::uint64_t dropped) {
  StageStats stats;
  stats.stage = name;
  stats.processed = processed;
  stats.dropped = dropped;
  return stats;
}

TEST(DropRate, CountsImagesWhateverElseAStageTakes) {
  DropRate rate;
  rate.observe({}, {stage("odometry", 0, 0)});
  // 100 readings of an AHRS a second beside 10 images, of which half find no room.
  EXPECT_DOUBLE_EQ(rate.observe({5, 5}, {stage("odometry", 105, 5)}), 0.5);
}

TEST(DropRate, IsThatOfTheStageThatKeepsUpTheLeast) {
  DropRate rate;
  rate.observe({}, {stage("mosaic2d", 0, 0), stage("projection3d", 0, 0)});
  EXPECT_DOUBLE_EQ(rate.observe({4, 6}, {stage("mosaic2d", 2, 2), stage("projection3d", 2, 2)}),
                   0.6);
  EXPECT_DOUBLE_EQ(rate.observe({8, 6}, {stage("mosaic2d", 2, 6), stage("projection3d", 6, 2)}),
                   0.75);
}

TEST(DropRate, LosesNothingByAlertsAndDatagrams) {
  DropRate rate;
  rate.observe({}, {stage("outputs", 0, 0), stage("record", 0, 0)});
  EXPECT_EQ(rate.observe({10, 0}, {stage("outputs", 1, 900), stage("record", 10, 3)}), 0);
}

TEST(DropRate, ForgetsAfterTenCalls) {
  DropRate rate;
  rate.observe({}, {});
  EXPECT_GT(rate.observe({5, 5}, {}), 0);
  double last = 1;
  for (std::uint64_t i = 1; i <= 11; ++i) last = rate.observe({5 + i, 5}, {});
  EXPECT_EQ(last, 0);
}

}  // namespace
}  // namespace nadir::app
