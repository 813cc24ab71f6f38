// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/lanes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nadir::coverage {
namespace {

using Eigen::Vector2d;

Plan plan_of(double bearing_deg) {
  return {{3, -2}, 20, 12, bearing_deg * std::numbers::pi / 180, 3};
}

/// Along the bearing, and to its right, from the corner.
Vector2d in_plan(const Plan& plan, double along, double right) {
  const double bearing = plan.bearing;
  return plan.corner + along * Vector2d(std::sin(bearing), std::cos(bearing)) +
         right * Vector2d(std::cos(bearing), -std::sin(bearing));
}

Vector2d moving(const Plan& plan, double along, double right) {
  return in_plan(plan, along, right) - plan.corner;
}

TEST(Lanes, RunThereAndBackAlongTheBearing) {
  for (const double bearing : {0.0, 90.0, 217.0}) {
    const Plan plan = plan_of(bearing);
    const std::vector<Lane> lanes = lanes_of(plan);
    ASSERT_EQ(lanes.size(), 4u);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const double right = 1.5 + 3.0 * static_cast<double>(i);
      const bool back = i % 2 != 0;
      EXPECT_LT((lanes[i].from - in_plan(plan, back ? 20 : 0, right)).norm(), 1e-9);
      EXPECT_LT((lanes[i].to - in_plan(plan, back ? 0 : 20, right)).norm(), 1e-9);
    }
    const Polygon ground = plan.ground();
    EXPECT_NEAR(area(ground), 240, 1e-9);
    EXPECT_LT((ground[2] - in_plan(plan, 20, 12)).norm(), 1e-9);
    const Polygon strip = strip_of(plan, 4, 2);
    EXPECT_LT((strip[0] - in_plan(plan, 0, 6)).norm(), 1e-9);
    EXPECT_LT((strip[2] - in_plan(plan, 20, 9)).norm(), 1e-9);
  }
}

TEST(Lanes, AreNoWiderThanTheirSpacing) {
  Plan plan = plan_of(0);
  plan.lane_spacing = 3.5;
  EXPECT_EQ(lanes_of(plan).size(), 4u);
  plan.lane_spacing = 30;
  EXPECT_EQ(lanes_of(plan).size(), 1u);
  plan.lane_spacing = 0;
  EXPECT_TRUE(lanes_of(plan).empty());
  plan.lane_spacing = 1e-5;
  EXPECT_TRUE(lanes_of(plan).empty());
}

TEST(Lanes, TheOneSwumIsTheOneWhoseStripAndDirectionAreTheVehicles) {
  for (const double bearing : {0.0, 130.0}) {
    const Plan plan = plan_of(bearing);
    const auto lane = [&](double along, double right, double ahead, double aside) {
      return LaneKeeper().observe(plan, 4, in_plan(plan, along, right), moving(plan, ahead, aside));
    };
    ASSERT_TRUE(lane(5, 2, 0.4, 0.1));
    EXPECT_EQ(lane(5, 2, 0.4, 0.1)->lane, 0);
    EXPECT_NEAR(lane(5, 2, 0.4, 0.1)->off, 0.5, 1e-9);
    ASSERT_TRUE(lane(5, 5, -0.4, 0.1));  // the second runs back: its right is the first's left
    EXPECT_EQ(lane(5, 5, -0.4, 0.1)->lane, 1);
    EXPECT_NEAR(lane(5, 5, -0.4, 0.1)->off, -0.5, 1e-9);
    EXPECT_FALSE(lane(5, 2, -0.4, 0));   // against it
    EXPECT_FALSE(lane(5, 2, 0.1, 0.4));  // across it
    EXPECT_FALSE(lane(5, 2, 0, 0));
    EXPECT_FALSE(lane(5, -0.1, 0.4, 0));
    EXPECT_FALSE(lane(5, 12.1, -0.4, 0));
    EXPECT_FALSE(lane(-0.1, 2, 0.4, 0));
  }
}

TEST(Lanes, AreKeptUntilTheyAreClearlyLeft) {
  const Plan plan = plan_of(40);
  LaneKeeper keeper;
  const auto at = [&](double along, double right, double ahead, double aside) {
    return keeper.observe(plan, 4, in_plan(plan, along, right), moving(plan, ahead, aside));
  };
  ASSERT_TRUE(at(1, 1, 1, 0));
  EXPECT_EQ(at(5, 3.5, 1, 0.2)->lane, 0);  // into its neighbour's strip
  EXPECT_NEAR(at(5, 3.5, 1, 0.2)->off, 2, 1e-9);
  EXPECT_EQ(at(9, 1.5, 0, 0)->lane, 0);
  EXPECT_EQ(at(9, 1.5, 0.1, 1)->lane, 0);  // avoids something
  EXPECT_EQ(at(22, 1.5, 1, 0)->lane, 0);   // the end of it
  EXPECT_FALSE(at(23.1, 1.5, 1, 0));       // past it
  EXPECT_FALSE(at(21, 4.5, -1, 0));        // not yet in the next
  EXPECT_EQ(at(19, 4.5, -1, 0)->lane, 1);
  EXPECT_EQ(at(10, 2.6, -1, 0)->lane, 1);  // a little off
  EXPECT_FALSE(at(10, 2.2, -1, 0));        // in the first one's strip, against it
  EXPECT_EQ(at(10, 2.2, 1, 0)->lane, 0);
  EXPECT_FALSE(at(10, 2.2, -1, 0));  // turned back
  EXPECT_FALSE(keeper.observe(plan, 0, plan.corner, {1, 1}));
}

}  // namespace
}  // namespace nadir::coverage
