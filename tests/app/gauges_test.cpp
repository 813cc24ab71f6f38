// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "gauges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "app/flat_seabed.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::app {
namespace {

using Eigen::Vector3d;
using wire::Quantity;

std::optional<wire::Measures::Measure> find(const wire::Measures& measures, Quantity quantity) {
  const auto found =
      std::ranges::find(measures.measures, quantity, &wire::Measures::Measure::quantity);
  return found == measures.measures.end() ? std::nullopt : std::optional(*found);
}

constexpr double kHeight = 2, kPeriod = 0.5, kStep = 0.2;

/// Swims to the north-east, an image of 2 m by 1.5 m every 0.2 m.
Gauges after(int images, const Config& config = {}) {
  Gauges gauges(config);
  for (int i = 0; i < images; ++i) {
    gauges.observe(seen_from(static_cast<std::uint64_t>(i), kPeriod * i,
                             looking_down_at(0, kStep * i, kHeight)));
  }
  return gauges;
}

TEST(Gauges, TellAltitudeSpeedAndOverlap) {
  const wire::Measures measures = after(8).measures({}, {}, {.usual_width = 2.4});
  const auto altitude = find(measures, Quantity::altitude), speed = find(measures, Quantity::speed),
             overlap = find(measures, Quantity::overlap);
  ASSERT_TRUE(altitude && speed && overlap);
  EXPECT_NEAR(altitude->value, kHeight, 1e-9);
  EXPECT_NEAR(*altitude->low, 2.4 / 1.5, 1e-9);
  EXPECT_NEAR(*altitude->high, 2.4 * 1.5, 1e-9);
  EXPECT_NEAR(speed->value, kStep / kPeriod, 1e-9);
  EXPECT_NEAR(*speed->high, 0.4 * 1.5 / kPeriod, 1e-3);
  EXPECT_NEAR(overlap->value, 1 - kStep / 1.5, 1e-9);
  EXPECT_EQ(overlap->low, 0.6);
}

TEST(Gauges, SayNothingOfWhatIsNotKnown) {
  EXPECT_TRUE(Gauges(Config()).measures({}, {}, {}).measures.empty());
  const wire::Measures first = after(1).measures({}, {}, {});
  EXPECT_TRUE(find(first, Quantity::altitude));
  EXPECT_FALSE(find(first, Quantity::altitude)->low);
  for (const Quantity quantity : {Quantity::speed, Quantity::overlap, Quantity::depth,
                                  Quantity::heading, Quantity::battery, Quantity::utc})
    EXPECT_FALSE(find(first, quantity));
  Gauges gauges = after(5);
  Orientation lost = seen_from(5, 2.5, {});
  lost.state = TrackingState::lost;
  lost.poses.clear();
  lost.window.reset();
  gauges.observe(lost);
  const wire::Measures then = gauges.measures({}, {}, {});
  for (const Quantity quantity : {Quantity::altitude, Quantity::speed, Quantity::overlap})
    EXPECT_FALSE(find(then, quantity));
  EXPECT_TRUE(find(then, Quantity::brightness));
}

TEST(Gauges, FollowTheScale) {
  Corrections corrections;
  corrections.add({0, 0, {3, {}}});
  const wire::Measures measures = after(8).measures(corrections, {}, {.usual_width = 2});
  EXPECT_NEAR(find(measures, Quantity::altitude)->value, 3 * kHeight, 1e-9);
  EXPECT_NEAR(*find(measures, Quantity::altitude)->high, 1.5 * 6, 1e-9);
  EXPECT_NEAR(find(measures, Quantity::speed)->value, 3 * kStep / kPeriod, 1e-9);
  EXPECT_NEAR(find(measures, Quantity::overlap)->value, 1 - kStep / 1.5, 1e-9);
}

TEST(Gauges, LimitTheAltitudeAsConfiguredOrByLanes) {
  Config config;
  config.guide.altitude_low = 1.2;
  const Gauges gauges = after(3, config);
  const auto metric =
      find(gauges.measures({}, {}, {.usual_width = 2, .metric = true}), Quantity::altitude);
  EXPECT_EQ(metric->low, 1.2);
  EXPECT_FALSE(metric->high);
  const auto unscaled = find(gauges.measures({}, {}, {.usual_width = 2}), Quantity::altitude);
  EXPECT_NEAR(*unscaled->low, 2 / 1.5, 1e-9);
  const auto lanes =
      find(gauges.measures({}, {}, {.usual_width = 2, .lane_spacing = 1.8}), Quantity::altitude);
  EXPECT_NEAR(*lanes->low, 2, 1e-9);
}

TEST(Gauges, TellWhatSensorsAndTheBoardKnow) {
  Gauges gauges(Config{});
  Orientation orientation = seen_from(0, 10, looking_down_at(0, 0, 2));
  Shot shot = *orientation.shot;
  Frame frame = *shot.frame;
  frame.depth = 12.5;
  frame.attitude = Attitude{0, 0, -0.2};
  shot.frame = std::make_shared<const Frame>(frame);
  orientation.shot = std::make_shared<const Shot>(shot);
  gauges.observe(orientation);
  const Board board{.battery = 0.8,
                    .temperature_deg = 51,
                    .free_bytes = 2e9,
                    .recording_left_s = 3600,
                    .utc_offset = from_seconds(1.7e9)};
  const wire::Measures measures = gauges.measures({}, board, {.convergence = 0.05});
  EXPECT_EQ(find(measures, Quantity::depth)->value, 12.5);
  EXPECT_NEAR(find(measures, Quantity::heading)->value, 2 * std::numbers::pi - 0.15, 1e-12);
  EXPECT_EQ(find(measures, Quantity::battery)->value, 0.8);
  EXPECT_EQ(find(measures, Quantity::temperature)->value, 51);
  EXPECT_EQ(find(measures, Quantity::free_space)->value, 2e9);
  EXPECT_EQ(find(measures, Quantity::recording_left)->value, 3600);
  EXPECT_NEAR(find(measures, Quantity::utc)->value, 1.7e9 + 10, 1e-6);
  EXPECT_NEAR(find(measures, Quantity::brightness)->value, 0.2, 1e-12);
  EXPECT_NEAR(find(measures, Quantity::blur)->value, 0.5, 1e-12);  // four times sharp enough
  EXPECT_EQ(find(measures, Quantity::blur)->high, 1);
}

TEST(Gauges, BlurIsThatOfTheMotionWhereTheExposureIsKnown) {
  // 0.4 m a second at 2 m with 400 px are 80 px a second.
  const wire::Measures measures = after(8).measures({}, {.exposure_ms = 20}, {});
  EXPECT_NEAR(find(measures, Quantity::blur)->value, 1.6, 0.02);
}

// The share of an image that another shows, pixel by pixel.
double true_overlap(const simulate::Survey& survey, int image, int before) {
  const cv::Mat1f depth = survey.depth(image);
  const CameraModel& camera = survey.rig()->left;
  const Rigid3 before_from_image =
      survey.survey_from_camera(before).inverse() * survey.survey_from_camera(image);
  int all = 0, shown = 0;
  for (int y = 0; y < depth.rows; y += 3) {
    for (int x = 0; x < depth.cols; x += 3) {
      const auto ray = camera.unproject({x, y});
      const auto pixel =
          camera.project(before_from_image * Vector3d(double{depth(y, x)} * ray->homogeneous()));
      ++all;
      shown += pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < camera.width &&
                       pixel->y() < camera.height
                   ? 1
                   : 0;
    }
  }
  return static_cast<double>(shown) / all;
}

double median_of(const cv::Mat1f& depth) {
  std::vector<float> values(depth.begin(), depth.end());
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return double{values[values.size() / 2]};
}

TEST(Gauges, AgreeWithTheTruthOfSimulatedDives) {
  for (const simulate::SceneKind scene :
       {simulate::SceneKind::pool, simulate::SceneKind::transect}) {
    simulate::Options options;
    options.scene = scene;
    options.stereo = true;
    options.images = 12;
    options.image_scale = 0.5;
    const simulate::Survey survey(options);
    odometry::VisualOdometry engine({}, [](const Window&, const auto&) {
      return SubmapPlacement{{}, {ScaleSource::stereo, 0.001}, SurveyAxes::first_camera, false};
    });
    Gauges gauges{Config()};
    int told = 0;
    for (int i = 0; i < options.images; ++i) {
      auto shot = std::make_shared<Shot>();
      shot->image = static_cast<std::uint64_t>(i);
      shot->time = survey.time(i);
      shot->frame = std::make_shared<const Frame>(survey.frame(i));
      gauges.observe(engine.process(shot));
      const wire::Measures measures = gauges.measures({}, {}, {});
      const auto altitude = find(measures, Quantity::altitude),
                 speed = find(measures, Quantity::speed),
                 overlap = find(measures, Quantity::overlap);
      if (i < 4 || !altitude || !speed || !overlap) continue;
      ++told;
      const double true_altitude = median_of(survey.depth(i));
      EXPECT_NEAR(altitude->value, true_altitude, 0.02 * true_altitude) << i;
      int since = i - 1;
      while (since > 0 && seconds(survey.time(i) - survey.time(since)) < 0.9) --since;
      const Vector3d way =
          survey.survey_from_camera(i).translation - survey.survey_from_camera(since).translation;
      const double true_speed = way.head<2>().norm() / seconds(survey.time(i) - survey.time(since));
      EXPECT_NEAR(speed->value, true_speed, 0.05 * true_speed) << i;
      EXPECT_NEAR(overlap->value, true_overlap(survey, i, i - 1), 0.05) << i;
    }
    EXPECT_GE(told, 5);
  }
}

}  // namespace
}  // namespace nadir::app
