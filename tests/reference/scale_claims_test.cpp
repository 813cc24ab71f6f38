// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/scale_claims.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "reference/flat_ground.hpp"

namespace nadir::reference {
namespace {

constexpr double kRatio = 2.5;  // metres per map unit

// A single camera's map whose altimeter hangs from some image on; its depth gauge works.
struct Dive {
  FlatGround ground{kRatio};
  ScaleClaims claims{0, std::nullopt, std::nullopt};
  std::vector<Alert> alerts;
  std::vector<ScaleEstimate> scales;

  Dive() { claims.placed(0, 1, {}); }

  void go_on(int images, bool altimeter_hangs, bool depth, double depth_factor = 1) {
    for (int i = 0; i < images; ++i) {
      const double height = 3 + 0.8 * std::sin(0.3 * i);
      const auto image = ground.image(0.2 * i, height);
      image.frame->altitude = altimeter_hangs ? 3 : height;
      if (depth) image.frame->depth = 18 - depth_factor * height;
      const Orientation orientation = ground.orientation(image);
      for (Alert& alert : claims.observe(orientation)) alerts.push_back(alert);
      for (const ScaleEstimate& scale : claims.improved(orientation)) scales.push_back(scale);
    }
  }
};

TEST(ScaleClaims, SensorThatFailsGivesWayToTheNextClaim) {
  Dive dive;
  dive.go_on(30, false, false);
  ASSERT_FALSE(dive.scales.empty());
  EXPECT_EQ(dive.scales.back().scale.source, ScaleSource::altitude);
  dive.go_on(30, true, false);
  ASSERT_EQ(dive.alerts.size(), 1u);
  EXPECT_EQ(dive.alerts[0].kind, AlertKind::sensor_stale);
  EXPECT_NE(dive.alerts[0].remedy.find("gives no scale from here on"), std::string::npos);
  dive.scales.clear();
  dive.go_on(60, true, true);
  ASSERT_FALSE(dive.scales.empty());
  EXPECT_EQ(dive.scales.back().scale.source, ScaleSource::depth);
  EXPECT_NEAR(dive.scales.back().ratio, kRatio, 0.02 * kRatio);
}

TEST(ScaleClaims, VerticalThatIsForgottenTakesTheDepthWithIt) {
  Dive dive;
  dive.go_on(60, true, true);
  ASSERT_FALSE(dive.scales.empty());
  EXPECT_EQ(dive.scales.back().scale.source, ScaleSource::depth);
  dive.claims.forget_vertical();
  dive.scales.clear();
  dive.go_on(60, true, true);
  EXPECT_TRUE(dive.scales.empty());
}

TEST(ScaleClaims, SourcesThatDisagreeAreToldOnce) {
  Dive dive;
  dive.go_on(80, false, true, 1.5);
  ASSERT_EQ(dive.alerts.size(), 1u);
  EXPECT_EQ(dive.alerts[0].kind, AlertKind::scale_conflict);
  EXPECT_NE(dive.alerts[0].message.find("by changes of depth the map is 50 % larger"),
            std::string::npos);
}

TEST(ScaleClaims, UnseenLasersOfAShortDiveAreToldAtItsEnd) {
  calibration::Lasers lasers;
  lasers.separation = 0.1;
  lasers.parallel_to_optical_axis = true;
  lasers.origins_in_camera = {{-0.05, 0.06, 0}, {0.05, 0.06, 0}};
  FlatGround ground;
  ScaleClaims claims(0, std::nullopt, lasers);
  claims.placed(0, 1, {});
  Time newest = 0;
  for (int i = 0; i < 12; ++i) {
    const auto image = ground.image(0.2 * i, 2);
    newest = image.pose.time;
    EXPECT_TRUE(claims.observe(ground.orientation(image)).empty());
  }
  const auto alerts = claims.observe(Orientation{});
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].time, newest);
  EXPECT_NE(alerts[0].message.find("0 of 12 images"), std::string::npos);
}

}  // namespace
}  // namespace nadir::reference
