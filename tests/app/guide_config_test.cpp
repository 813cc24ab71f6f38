// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "config_file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

std::string fault_of(const std::vector<std::string>& assignments) {
  Config config;
  try {
    for (const std::string& assignment : assignments) read_assignment(assignment, config);
    config.check();
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(GuideConfig, RefusesWhatIsNoPlanAndSaysWhatItMustBe) {
  using List = std::vector<std::string>;
  for (const auto& [assignments, said] : std::vector<std::pair<List, std::string>>{
           {{"plan.length=10"}, "plan.width must be given with plan.length"},
           {{"plan.width=10"}, "plan.width must be given with plan.length"},
           {{"plan.length=-1", "plan.width=2"}, "plan.length must be 0 to 10000 m"},
           {{"plan.length=20000", "plan.width=2"}, "plan.length must be"},
           {{"plan.length=9", "plan.width=2", "plan.lane_spacing=-1"}, "plan.lane_spacing must be"},
           {{"plan.length=9", "plan.width=9", "plan.lane_spacing=1e-4"}, "plan.lane_spacing must"},
           {{"plan.bearing_deg=361"}, "plan.bearing_deg must be -360 to 360"},
           {{"plan.corner_latitude=91"}, "plan.corner_latitude must be"},
           {{"plan.corner_latitude=43", "plan.corner_x=3"}, "plan.corner_x must be 0"},
           {{"plan.length=9", "plan.width=2", "plan.corner_latitude=43.3"}, "reference.origin"},
           {{"plan.length=9", "plan.width=2", "plan.corner_latitude=43.3",
             "plan.corner_longitude=5.4", "reference.origin=60 5"},
            "more than 100 km from reference.origin"},
           {{"guide.overlap_low=1"}, "guide.overlap_low must be between 0 and 1"},
           {{"guide.altitude_low=3", "guide.altitude_high=2"}, "guide.altitude_high must be"},
           {{"plan.length=nan"}, "plan.length must be a number"}}) {
    EXPECT_THAT(fault_of(assignments), testing::HasSubstr(said)) << assignments.front();
  }
  EXPECT_EQ(fault_of({"plan.length=100", "plan.width=50", "plan.lane_spacing=1.5"}), "none");
}

TEST(GuideConfig, PlansByTheSurveyOrByAPositionOnTheEarth) {
  EXPECT_FALSE(planned({}, {}));
  PlanConfig config{.length = 30, .width = 20, .bearing_deg = 90, .lane_spacing = 2};
  config.corner_x = 5;
  const auto plan = planned(config, {});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->corner, Eigen::Vector2d(5, 0));
  EXPECT_NEAR(plan->bearing, std::numbers::pi / 2, 1e-12);

  const reference::UtmGrid grid({43.2965, 5.3698, 0});
  const auto place = grid.geodetic({120, -45, 0});
  config.corner_x = 0;
  config.corner_latitude = place->latitude_deg;
  config.corner_longitude = place->longitude_deg;
  const auto there = planned(config, grid);
  ASSERT_TRUE(there);
  EXPECT_LT((there->corner - Eigen::Vector2d(120, -45)).norm(), 1e-3);
}

}  // namespace
}  // namespace nadir::app
