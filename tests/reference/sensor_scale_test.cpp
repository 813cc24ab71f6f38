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

// By half a degree, as an AHRS is mounted.
std::optional<ScaleMeasure> by_depth_on_a_tilted_map(double rise, double heave) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  for (int i = 0; i < 40; ++i) {
    const double x = 0.3 * i, height = 3 + rise * x + heave * std::sin(0.5 * i);
    auto image = ground.image(x, height);
    image.frame->depth = 18 - height + ground.noise(0.01);
    image.pose.survey_from_camera.translation.z() += 0.01 * x / kRatio;
    scale.observe(ground.orientation(image));
  }
  return scale.by_depth(0);
}

TEST(SensorScale, DepthsTellHeaveFromTheTiltOfTheMap) {
  const auto measure = by_depth_on_a_tilted_map(0, 0.3);
  ASSERT_TRUE(measure);
  EXPECT_NEAR(measure->ratio, kRatio, 3 * measure->sigma * kRatio);
  EXPECT_LT(measure->sigma, 0.025);  // 0.01 m of 0.2 m, of 8 independent images; the gauge's slope
}

// Along a slope of 5 degrees the map is a tenth too high, and nothing shows it.
TEST(SensorScale, DepthsAlongAnEvenSlopeSayNothing) {
  EXPECT_FALSE(by_depth_on_a_tilted_map(0.09, 0));
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

// Centimetres or millimetres for metres, or the other way: no ground is seen from there.
TEST(SensorScale, AltimeterOfAnotherUnitGivesNoScaleAndIsToldOnce) {
  for (const double unit : {0.01, 100.0, 1000.0}) {
    FlatGround ground{kRatio};
    SensorScale scale(0);
    std::vector<SensorFault> told;
    for (int i = 0; i < 40; ++i) {
      const double height = 2 + 0.3 * std::sin(0.4 * i);
      const auto image = ground.image(0.2 * i, height);
      image.frame->altitude = unit * height;
      scale.observe(ground.orientation(image));
      for (const SensorFault& fault : scale.new_faults(0)) told.push_back(fault);
      EXPECT_FALSE(scale.by_altitude(0));
    }
    ASSERT_EQ(told.size(), 1u) << unit;
    EXPECT_NE(told[0].message.find("m to the ground"), std::string::npos) << told[0].message;
  }
}

TEST(SensorScale, DepthThatGrowsUpwardsIsToldOnce) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  std::vector<SensorFault> told;
  for (int i = 0; i < 60; ++i) {
    const double height = 3 + 0.8 * std::sin(0.15 * i);
    const auto image = ground.image(0.2 * i, height);
    image.frame->depth = height - 18 + ground.noise(0.02);
    scale.observe(ground.orientation(image));
    for (const SensorFault& fault : scale.new_faults(0)) told.push_back(fault);
  }
  EXPECT_FALSE(scale.by_depth(0));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("grows while the images rise"), std::string::npos);
  EXPECT_NE(told[0].remedy.find("positive down"), std::string::npos);
}

// A gauge behind the camera sinks when the vehicle pitches and the camera rises; a swell lifts both
// the water and what floats in it. Neither is a gauge that counts upwards.
TEST(SensorScale, GoodGaugesAreNotTakenForOnesThatGrowUpwards) {
  for (const bool metric : {false, true}) {
    FlatGround ground{metric ? 1.0 : kRatio};
    SensorScale pitching(0), swell(0), film(0);
    for (int i = 0; i < 200; ++i) {
      const double lifted = 0.2 * std::sin(0.9 * i), height = 2 + lifted;
      auto image = ground.image(0.2 * i, height);
      const auto seen_by = [&](SensorScale& scale, double depth) {
        image.frame->depth = depth + ground.noise(0.01);
        auto orientation = ground.orientation(image);
        scale.observe(orientation);
        EXPECT_TRUE(scale.new_faults(0).empty()) << metric << ' ' << i;
      };
      seen_by(pitching, 16 + 0.5 * lifted);
      seen_by(swell, 15 + 0.1 * lifted);
      if (i < 14) seen_by(film, 16 + lifted);  // too few to tell
    }
  }
}

TEST(SensorScale, HangingSensorIsToldOnceTheImagesMoved) {
  FlatGround ground{kRatio};
  SensorScale moving(0), level(0);
  std::vector<SensorFault> told;
  for (int i = 0; i < 40; ++i) {
    const auto rising = ground.image(0.2 * i, 2 + 0.8 * std::sin(0.3 * i)),
               steady = ground.image(0.2 * i, 2);
    for (const auto& image : {rising, steady}) {
      image.frame->altitude = 2.2;
      image.frame->depth = 15;
    }
    moving.observe(ground.orientation(rising));
    level.observe(ground.orientation(steady));
    for (const SensorFault& fault : moving.new_faults(0)) told.push_back(fault);
    EXPECT_TRUE(level.new_faults(0).empty());
  }
  ASSERT_EQ(told.size(), 2u);
  EXPECT_NE(told[0].message.find("altitude.csv: the same value"), std::string::npos);
  EXPECT_EQ(told[0].source, ScaleSource::altitude);
  EXPECT_NE(told[0].remedy.find("no scale from here on"), std::string::npos);
  EXPECT_NE(told[1].message.find("depth.csv: the same value"), std::string::npos);
  EXPECT_EQ(told[1].source, ScaleSource::depth);
}

// What good sensors give, rounded as they do, is no fault of theirs.
struct Rounded {
  double hz = 2, tilt = 0, heave = 0, height = 2, step = 0.1;
  bool metric = true;
  std::size_t images = 200;

  std::vector<SensorFault> faults() const {
    FlatGround ground{metric ? 1 : kRatio};
    ground.hz = hz;
    if (metric) ground.scale = {ScaleSource::altitude, 0.03};
    SensorScale scale(0);
    std::vector<SensorFault> told;
    for (std::size_t i = 0; i < images; ++i) {
      const double x = 0.2 * static_cast<double>(i);
      const double up = heave * std::sin(0.3 * static_cast<double>(i));
      const auto image = ground.image(x, height + up);
      image.frame->altitude = step * std::round((height + up) / step);
      image.frame->depth = step * std::round((15 - up) / step);
      Orientation orientation = ground.orientation(image);
      orientation.poses[0].survey_from_camera.translation.z() += tilt * x / ground.metres_per_unit;
      scale.observe(orientation);
      for (const SensorFault& fault : scale.new_faults(0)) told.push_back(fault);
    }
    return told;
  }
};

TEST(SensorScale, SteadyGaugeOverATiltedMapDoesNotHang) {
  for (const bool metric : {true, false}) {
    Rounded dive;
    dive.tilt = 0.035;  // 2 degrees
    dive.metric = metric;
    for (const SensorFault& fault : dive.faults()) {
      EXPECT_NE(fault.source, ScaleSource::depth) << fault.message;
    }
  }
}

TEST(SensorScale, GaugeBeforeAWallDoesNotHang) {
  FlatGround ground;
  ground.scale = {ScaleSource::laser, 0.02};
  SensorScale scale(0);
  for (int i = 0; i < 60; ++i) {
    auto image = ground.image(0.05 * i, 2 + 0.04 * std::sin(i));
    image.frame->depth = 15;
    Orientation orientation = ground.orientation(image);
    auto window = std::make_shared<Window>(*orientation.window);
    for (TiePoint& point : window->tie_points) {  // as high as the camera on the mean
      point.x_in_survey.z() = point.x_in_survey.y();
      point.x_in_survey.y() = 2;
      point.x_in_survey += Eigen::Vector3d(0, 0, 2);
    }
    orientation.window = window;
    orientation.poses[0].survey_from_camera.rotation =
        Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX());
    scale.observe(orientation);
    EXPECT_TRUE(scale.new_faults(0).empty());
  }
}

TEST(SensorScale, CoarseAltimeterDoesNotHang) {
  Rounded dive;
  dive.heave = 0.045;
  dive.height = 0.8;
  EXPECT_TRUE(dive.faults().empty());
}

TEST(SensorScale, ImagesOfAFilmAreAnInstant) {
  FlatGround ground{kRatio};
  ground.hz = 30;
  SensorScale silent(0), hanging(0), noisy(0);
  for (int i = 0; i < 170; ++i) {
    const double height = 2 + 0.5 * std::sin(0.3 * i);
    const auto dark = ground.image(0.01 * i, height);
    ground.images = dark.frame->image;
    const auto same = ground.image(0.01 * i, height);
    ground.images = dark.frame->image;
    const auto wild = ground.image(0.01 * i, 2);
    dark.frame->altitude = 0;
    same.frame->altitude = 2;
    same.frame->depth = 15;
    wild.frame->altitude = 2 * std::exp(ground.noise(0.6));
    silent.observe(ground.orientation(dark));
    hanging.observe(ground.orientation(same));
    noisy.observe(ground.orientation(wild));
    const std::size_t told =
        silent.new_faults(0).size() + hanging.new_faults(0).size() + noisy.new_faults(0).size();
    if (i < 149) {
      EXPECT_EQ(told, 0u) << i;
    }
  }
  EXPECT_TRUE(silent.new_faults(0).empty());
}

TEST(SensorScale, DepthSaysNothingOnceTheVerticalIsForgotten) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  for (int i = 0; i < 120; ++i) {
    const double height = 3 + 0.8 * std::sin(0.15 * i);
    const auto image = ground.image(0.2 * i, height);
    image.frame->depth = 18 - height;
    scale.observe(ground.orientation(image));
    if (i == 59) {
      EXPECT_TRUE(scale.by_depth(0));
      scale.forget_vertical();
    }
  }
  EXPECT_FALSE(scale.by_depth(0));
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

TEST(SensorScale, AltimeterWithoutEchoIsToldAndGivesAScaleWhenItHears) {
  FlatGround ground{kRatio};
  SensorScale scale(0);
  std::size_t told = 0;
  for (int i = 0; i < 80; ++i) {
    const auto image = ground.image(0.2 * i, 2);
    image.frame->altitude = i < 40 ? 0 : 2 + ground.noise(0.02);
    scale.observe(ground.orientation(image));
    told += scale.new_faults(0).size();
  }
  EXPECT_EQ(told, 1u);
  EXPECT_TRUE(scale.by_altitude(0));
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
