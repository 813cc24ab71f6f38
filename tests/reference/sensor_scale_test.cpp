// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/sensor_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "reference/flat_ground.hpp"

namespace nadir::reference {
namespace {

constexpr double kRatio = 2.5;  // metres per map unit

TEST(SensorScale, AltimeterMeasuresAlongItsSlantingBeam) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  for (int i = 0; i < 40; ++i) {
    const double height = 2 + 0.3 * std::sin(0.4 * i), roll = 0.2 * std::sin(i);
    const auto image = ground.image(0.2 * i, height, roll);
    image.frame->altitude = height / std::cos(roll) + ground.noise(0.02);
    scale.observe(ground.orientation(image));
  }
  const auto measure = scale.by_altitude(0);
  ASSERT_TRUE(measure);
  EXPECT_EQ(measure->images, 40u);
  EXPECT_NEAR(measure->ratio, kRatio, 0.01 * kRatio);  // 0.02 m of 2 m, of 40 images
  EXPECT_GT(measure->sigma, 0.02);                     // speed of sound, lever arm
  EXPECT_LT(measure->sigma, 0.05);
  EXPECT_FALSE(scale.by_altitude(1));
  EXPECT_FALSE(scale.by_depth(0));
}

TEST(SensorScale, AltimeterBelowTheLensIsNearerToTheGround) {
  FlatGround ground{kRatio};
  SensorScale scale(0.3);
  for (int i = 0; i < 10; ++i) {
    const auto image = ground.image(0, 2);
    image.frame->altitude = 1.7 + ground.noise(0.005);
    scale.observe(ground.orientation(image));
  }
  EXPECT_NEAR(scale.by_altitude(0)->ratio, kRatio, 0.005 * kRatio);
}

TEST(SensorScale, AltimeterThatHangsOrIsNewSaysNothing) {
  FlatGround ground{kRatio};
  SensorScale hanging(0), fresh(0);
  for (int i = 0; i < 20; ++i) {
    const auto image = ground.image(0, 2 + 0.01 * i);
    image.frame->altitude = 2.2;
    hanging.observe(ground.orientation(image));
    if (i < 4) fresh.observe(ground.orientation(image));
  }
  EXPECT_FALSE(hanging.by_altitude(0));
  EXPECT_FALSE(fresh.by_altitude(0));
}

TEST(SensorScale, ChangesOfDepthMeasureWithinTheirSigma) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  for (int i = 0; i < 60; ++i) {
    const double height = 3 + 0.8 * std::sin(0.15 * i);
    const auto image = ground.image(0.2 * i, height);
    image.frame->depth = 18 - height + ground.noise(0.02);
    if (i == 30) *image.frame->depth += 3;  // a fault of the gauge
    scale.observe(ground.orientation(image));
  }
  const auto measure = scale.by_depth(0);
  ASSERT_TRUE(measure);
  EXPECT_NEAR(measure->ratio, kRatio, 3 * measure->sigma * kRatio);
  EXPECT_LT(measure->sigma, 0.03);
  EXPECT_FALSE(scale.by_altitude(0));
}

TEST(SensorScale, DepthThatHardlyChangesOrWithoutAVerticalSaysNothing) {
  FlatGround ground{kRatio};
  SensorScale level(0), tilted(0);
  for (int i = 0; i < 60; ++i) {
    const double height = 3 + 0.8 * std::sin(0.15 * i);
    const auto steady = ground.image(0.2 * i, 3), changing = ground.image(0.2 * i, height);
    steady.frame->depth = 15 + ground.noise(0.02);
    changing.frame->depth = 18 - height;
    level.observe(ground.orientation(steady));
    tilted.observe(ground.orientation(changing, SurveyAxes::first_plane));
  }
  EXPECT_FALSE(level.by_depth(0));
  EXPECT_FALSE(tilted.by_depth(0));
}

}  // namespace
}  // namespace nadir::reference
