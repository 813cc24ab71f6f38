// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/sensor_track.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nadir {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

double angle_at(const SensorTrack& track, double s) { return track.at(from_seconds(s)).value()[1]; }

TEST(SensorTrack, InterpolatesAnglesTheShortWayAndOthersStraight) {
  SensorTrack track({0, kTurn, 0});
  EXPECT_TRUE(track.add(from_seconds(1), {10, kTurn - 0.1, 5}));
  EXPECT_TRUE(track.add(from_seconds(1.4), {12, 0.1, 5}));
  EXPECT_DOUBLE_EQ(track.at(from_seconds(1.1)).value()[0], 10.5);
  EXPECT_NEAR(angle_at(track, 1), -0.1, 1e-12);
  EXPECT_NEAR(angle_at(track, 1.1), -0.05, 1e-12);
  EXPECT_NEAR(angle_at(track, 1.3), 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(track.at(from_seconds(1.4)).value()[2], 5);
}

TEST(SensorTrack, SaysNothingAcrossAGapOrOutsideItsRows) {
  SensorTrack track;
  EXPECT_FALSE(track.at(0));
  track.add(from_seconds(1), {});
  track.add(from_seconds(1.5), {});
  track.add(from_seconds(2.01), {});
  EXPECT_TRUE(track.at(from_seconds(1.2)));
  EXPECT_FALSE(track.at(from_seconds(1.7)));
  EXPECT_TRUE(track.at(from_seconds(2.01)));
  EXPECT_FALSE(track.at(from_seconds(0.999)));
  EXPECT_FALSE(track.at(from_seconds(2.02)));
}

TEST(SensorTrack, LeavesOutWhatIsNotLaterAndForgets) {
  SensorTrack track;
  EXPECT_TRUE(track.add(2, {1}));
  EXPECT_FALSE(track.add(2, {2}));
  EXPECT_FALSE(track.add(1, {3}));
  EXPECT_TRUE(track.add(3, {4}));
  EXPECT_EQ(track.rows().size(), 2u);
  track.forget_before(3);
  ASSERT_EQ(track.rows().size(), 1u);
  EXPECT_EQ(track.rows().front().values[0], 4);
  track.forget_before(4);
  EXPECT_TRUE(track.rows().empty());
}

}  // namespace
}  // namespace nadir
