// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_log.hpp"

#include <gtest/gtest.h>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

SensorLog log_of(std::string_view content, bool angle = false) {
  const SurveyFolder folder;
  folder.write("x.csv", content);
  return SensorLog(folder.root() / "x.csv", {{"value", -360, 360, angle}});
}

std::optional<double> at(const SensorLog& log, double s) {
  const auto values = log.at(from_seconds(s));
  return values ? std::optional((*values)[0]) : std::nullopt;
}

TEST(SensorLog, InterpolatesBetweenRows) {
  const SensorLog log = log_of("seconds,value\n1,10\n1.4,12\n");
  EXPECT_DOUBLE_EQ(at(log, 1).value(), 10);
  EXPECT_DOUBLE_EQ(at(log, 1.1).value(), 10.5);
  EXPECT_DOUBLE_EQ(at(log, 1.4).value(), 12);
}

TEST(SensorLog, GivesNothingAcrossAGapOrOutsideItsRows) {
  const SensorLog log = log_of("seconds,value\n1,10\n1.5,11\n2.01,12\n");
  EXPECT_TRUE(at(log, 1.2));
  EXPECT_FALSE(at(log, 1.7));
  EXPECT_TRUE(at(log, 2.01));
  EXPECT_FALSE(at(log, 0.999));
  EXPECT_FALSE(at(log, 2.02));
  EXPECT_FALSE(at(log_of("seconds,value\n"), 0));
}

TEST(SensorLog, TurnsAnglesTheShortWay) {
  const SensorLog north = log_of("seconds,value\n0,350\n0.4,10\n", true);
  EXPECT_NEAR(at(north, 0.2).value(), 0, 1e-9);
  EXPECT_NEAR(at(north, 0.1).value(), -5, 1e-9);
  const SensorLog south = log_of("seconds,value\n0,170\n0.4,-170\n", true);
  EXPECT_NEAR(at(south, 0.1).value(), 175, 1e-9);
  EXPECT_NEAR(at(south, 0.3).value(), -175, 1e-9);
  EXPECT_NEAR(at(log_of("seconds,value\n0,350\n0.4,10\n"), 0.2).value(), 180, 1e-9);
}

TEST(SensorLog, DropsAndCountsRowsThatCannotBe) {
  const SensorLog log =
      log_of("seconds,value\n0,1\nnan,2\n0.1,inf\n0.2,\n0.3,1000\n0.4,5\n0.4,6\n0.2,3\n1e300,4\n");
  EXPECT_EQ(log.size(), 3u);
  EXPECT_EQ(log.dropped(), 6u);
  EXPECT_DOUBLE_EQ(at(log, 0.1).value(), 2);  // rows may come in any order
  EXPECT_DOUBLE_EQ(at(log, 0.4).value(), 5);
}

TEST(SensorLog, TimesWhoseDifferenceOverflowsAreDropped) {
  const SensorLog log = log_of("seconds,value\n-9e9,1\n-4.61e9,1\n-4.5e9,1\n4.5e9,2\n8.9e9,3\n");
  EXPECT_EQ(log.size(), 2u);
  const auto [from, to] = log.span();
  EXPECT_GT(to - from, 0);
  EXPECT_FALSE(at(log, 0));
}

}  // namespace
}  // namespace nadir::capture
