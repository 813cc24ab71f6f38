// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/sensor_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

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

TEST(SensorScale, NoisyAltimeterGivesNoScaleAndIsToldOnce) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  std::size_t told = 0;
  for (int i = 0; i < 40; ++i) {
    const auto image = ground.image(0.2 * i, 2);
    image.frame->altitude = 2 * std::exp(ground.noise(0.6));
    scale.observe(ground.orientation(image));
    for (const SensorFault& fault : scale.new_faults(0)) {
      ++told;
      EXPECT_NE(fault.message.find("altitude.csv: scatters by"), std::string::npos);
    }
  }
  EXPECT_EQ(told, 1u);
  EXPECT_FALSE(scale.by_altitude(0));
}

TEST(SensorScale, HangingSensorIsToldOnceTheImagesMoved) {
  FlatGround ground{kRatio};
  SensorScale moving(0), level(0);
  std::vector<std::string> told;
  for (int i = 0; i < 40; ++i) {
    const auto rising = ground.image(0.2 * i, 2 + 0.02 * i), steady = ground.image(0.2 * i, 2);
    for (const auto& image : {rising, steady}) {
      image.frame->altitude = 2.2;
      image.frame->depth = 15;
    }
    moving.observe(ground.orientation(rising));
    level.observe(ground.orientation(steady));
    for (const SensorFault& fault : moving.new_faults(0)) told.push_back(fault.message);
    EXPECT_TRUE(level.new_faults(0).empty());
  }
  ASSERT_EQ(told.size(), 2u);
  EXPECT_NE(told[0].find("altitude.csv: the same value"), std::string::npos);
  EXPECT_NE(told[1].find("depth.csv: the same value"), std::string::npos);
}

TEST(SensorScale, AltimeterThatWorkedGivesNoScaleOnceItHangs) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  std::size_t told = 0;
  for (int i = 0; i < 80; ++i) {
    const double height = 2 + 0.5 * std::sin(0.2 * i);
    const auto image = ground.image(0.2 * i, height);
    image.frame->altitude = i < 40 ? height : 2.2;
    scale.observe(ground.orientation(image));
    told += scale.new_faults(0).size();
    EXPECT_TRUE(i != 39 || scale.by_altitude(0));
  }
  EXPECT_EQ(told, 1u);
  EXPECT_FALSE(scale.by_altitude(0));
}

TEST(SensorScale, AltimeterWithoutEchoIsTold) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  std::size_t told = 0;
  for (int i = 0; i < 40; ++i) {
    const auto image = ground.image(0.2 * i, 2);
    image.frame->altitude = 0;
    scale.observe(ground.orientation(image));
    told += scale.new_faults(0).size();
  }
  EXPECT_EQ(told, 1u);
}

TEST(SensorScale, DepthThatHasNothingToDoWithTheImagesIsTold) {
  FlatGround ground{kRatio};
  SensorScale noisy(0), heaving(0);
  std::size_t told = 0;
  for (int i = 0; i < 40; ++i) {
    const double height = 3 + 0.8 * std::sin(0.5 * i);
    const auto image = ground.image(0.2 * i, 3 + ground.noise(0.02)),
               moved = ground.image(0.2 * i, height);
    image.frame->depth = 15 + ground.noise(1);
    moved.frame->depth = 18 - height + ground.noise(0.1);
    noisy.observe(ground.orientation(image));
    heaving.observe(ground.orientation(moved));
    told += noisy.new_faults(0).size();
    EXPECT_TRUE(heaving.new_faults(0).empty());
  }
  EXPECT_EQ(told, 1u);
}

}  // namespace
}  // namespace nadir::reference
