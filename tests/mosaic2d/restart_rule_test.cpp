// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "restart_rule.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <vector>

namespace nadir::mosaic2d {
namespace {

// Two metres above the plane through (0, 0, height) that slopes in x.
Stand stand(double slope_deg, double height = 0, double rms = 0.01) {
  const double slope = slope_deg * std::numbers::pi / 180;
  Stand stand;
  stand.plane.normal = {std::sin(slope), 0, std::cos(slope)};
  stand.plane.offset = std::cos(slope) * height;
  stand.plane.rms = rms;
  stand.footprint.centre = {0, 0, height};
  stand.footprint.viewing_distance = 2;
  stand.footprint.sampling_distance = 0.004;
  return stand;
}

// The numbers of the images that began a new mosaic.
std::vector<int> restarts(const std::vector<Stand>& stands) {
  const Config config;
  RestartRule rule(config, stands.front());
  std::vector<int> restarts;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    if (rule.reason(stands[i]).empty()) continue;
    restarts.push_back(static_cast<int>(i));
    rule = RestartRule(config, stands[i]);
  }
  return restarts;
}

std::string reason_after_two(const Stand& first, const Stand& then) {
  RestartRule rule(Config{}, first);
  EXPECT_EQ(rule.reason(then), "");
  return rule.reason(then);
}

TEST(RestartRule, RestartsExactlyByTheAngleOnASlowWalkOfTheNormal) {
  std::vector<Stand> walk;
  for (int i = 0; i < 1000; ++i) walk.push_back(stand(0.06 * i));
  // Beyond 25 degrees from image 417 on, so the second in a row is 418; from there again 417 on.
  EXPECT_EQ(restarts(walk), (std::vector<int>{418, 836}));
}

TEST(RestartRule, StaysOnAWalkOfOneDegree) {
  std::vector<Stand> walk;
  for (int i = 0; i < 1000; ++i) walk.push_back(stand(0.001 * i));
  EXPECT_TRUE(restarts(walk).empty());
}

TEST(RestartRule, DoesNotFlapAroundTheLimit) {
  std::vector<Stand> waver{stand(0)};
  for (int i = 0; i < 1000; ++i) waver.push_back(stand(i % 2 == 0 ? 25.5 : 24.5));
  EXPECT_TRUE(restarts(waver).empty());
  for (int i = 0; i < 1000; ++i) waver.push_back(stand(i % 3 == 0 ? 24.5 : 25.5));
  EXPECT_EQ(restarts(waver).size(), 1u);  // the new mosaic's own plane is 25 degrees further on
}

TEST(RestartRule, ForgivesASingleDeparture) {
  EXPECT_TRUE(restarts({stand(0), stand(40), stand(0), stand(40), stand(0)}).empty());
  EXPECT_EQ(restarts({stand(0), stand(40), stand(40)}), (std::vector<int>{2}));
}

TEST(RestartRule, NamesTheReason) {
  const Stand flat = stand(0);
  EXPECT_NE(reason_after_two(flat, stand(30)).find("turned by 30 degrees"), std::string::npos);
  EXPECT_NE(reason_after_two(flat, stand(0, 0.7)).find("by 35 %"), std::string::npos);
  EXPECT_NE(reason_after_two(flat, stand(0, -0.7)).find("by 35 %"), std::string::npos);
  EXPECT_NE(reason_after_two(flat, stand(0, 0, 0.05)).find("rougher, 2.5 %"), std::string::npos);
  Stand far = flat, near = flat;
  far.footprint.sampling_distance = 0.01;
  near.footprint.sampling_distance = 0.001;
  EXPECT_NE(reason_after_two(flat, far).find("factor of 2.5"), std::string::npos);
  EXPECT_NE(reason_after_two(flat, near).find("resolution"), std::string::npos);
}

TEST(RestartRule, AllowsForTheSmoothnessOfTheFirstPlane) {
  EXPECT_EQ(reason_after_two(stand(0, 0, 1e-6), stand(0, 0, 0.035)), "");  // below 2 x 1 %
  EXPECT_EQ(reason_after_two(stand(0, 0, 0.04), stand(0, 0, 0.07)), "");   // below 2 x 2 %
}

TEST(RestartRule, FollowsTheSubmapAtOnce) {
  RestartRule rule(Config{}, stand(0));
  Stand next = stand(0);
  next.submap = 1;
  EXPECT_EQ(rule.reason(next), "a new sub-map began");
}

}  // namespace
}  // namespace nadir::mosaic2d
