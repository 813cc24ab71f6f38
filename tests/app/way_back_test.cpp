// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "way_back.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "app/flat_seabed.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "nadir/plane/plane_fit.hpp"
#include "nadir/reference/survey_frame.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::app {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr std::uint32_t kEnough = 40;
constexpr double kNear = 0.5;

wire::LiveImage live_of(const Orientation& orientation) {
  return {orientation.shot->image, orientation.shot->time, {1, 2, 3}};
}

Orientation lost_at(std::uint64_t image, const Rigid3& reckoned, double sigma) {
  Orientation orientation = seen_from(image, static_cast<double>(image), {});
  orientation.state = TrackingState::lost;
  orientation.poses.clear();
  orientation.window.reset();
  orientation.dead_reckoned = DeadReckoned{image, 0, reckoned, sigma};
  return orientation;
}

void observe(WayBack& way_back, const Orientation& orientation) {
  const wire::LiveImage live = live_of(orientation);
  way_back.observe(orientation, &live);
}

double angle_between(double a, double b) { return std::remainder(a - b, 2 * pi); }

TEST(WayBack, LeadsToTheLastGoodViewOnce) {
  WayBack way_back(kEnough);
  observe(way_back, seen_from(0, 0, looking_down_at(0, 0, 2)));
  observe(way_back, seen_from(1, 1, looking_down_at(0, 1, 2)));
  Orientation weak = seen_from(2, 2, looking_down_at(0, 2, 2));
  weak.poses[0].tie_points = 12;
  observe(way_back, weak);
  EXPECT_FALSE(way_back.is_lost());
  EXPECT_FALSE(way_back.take_last_view());
  EXPECT_FALSE(way_back.way({}, kNear).lost);
  observe(way_back, lost_at(3, looking_down_at(0, 3, 2), 0.4));
  EXPECT_TRUE(way_back.is_lost());
  const auto view = way_back.take_last_view();
  ASSERT_TRUE(view);
  EXPECT_EQ(view->image, 1u);
  EXPECT_EQ(view->jpeg.size(), 3u);
  EXPECT_FALSE(way_back.take_last_view());
  const wire::WayBack way = way_back.way({}, kNear);
  EXPECT_TRUE(way.lost && way.known);
  EXPECT_NEAR(std::abs(way.turn), pi, 1e-9);
  EXPECT_NEAR(way.distance, 2, 1e-9);
  EXPECT_EQ(way.sigma, 0.4);
  observe(way_back, seen_from(4, 4, looking_down_at(0, 4, 2)));
  EXPECT_FALSE(way_back.is_lost());
  EXPECT_FALSE(way_back.way({}, kNear).lost);
}

TEST(WayBack, TurnsClockwiseFromTheTopOfTheImage) {
  for (double heading = -3; heading <= 3; heading += 0.5) {
    for (const Vector2d& here : {Vector2d(3, 0), {0, -2}, {-1, 1}, {2, 2.5}}) {
      WayBack way_back(kEnough);
      observe(way_back, seen_from(0, 0, looking_down_at(0, 0, 2)));
      observe(way_back, lost_at(1, looking_down_at(here.x(), here.y(), 2.4, heading), 0.1));
      const wire::WayBack way = way_back.way({}, kNear);
      const double bearing = std::atan2(-here.x(), -here.y());  // of the view, from north
      EXPECT_NEAR(angle_between(way.turn, bearing - heading), 0, 1e-9);
      EXPECT_NEAR(way.distance, here.norm(), 1e-9);
    }
  }
}

TEST(WayBack, IsUnknownWhenItCannotBeTold) {
  WayBack never(kEnough);
  observe(never, lost_at(0, {}, 0));
  EXPECT_TRUE(never.way({}, kNear).lost);
  EXPECT_FALSE(never.way({}, kNear).known);
  EXPECT_FALSE(never.take_last_view());
  WayBack far(kEnough);
  observe(far, seen_from(0, 0, looking_down_at(0, 0, 2)));
  Orientation lost = lost_at(1, looking_down_at(0, 2, 2), 3);
  observe(far, lost);
  EXPECT_FALSE(far.way({}, kNear).known);
  EXPECT_TRUE(far.way({}, 4).known);
  lost.dead_reckoned.reset();
  observe(far, lost);
  EXPECT_FALSE(far.way({}, 4).known);
}

TEST(WayBack, FollowsCorrections) {
  WayBack way_back(kEnough);
  observe(way_back, seen_from(0, 0, looking_down_at(0, 0, 2)));
  observe(way_back, lost_at(1, looking_down_at(0, 2, 2), 0.5));
  Corrections corrections;
  corrections.add(
      {0,
       0,
       {2, {Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ())), {7, 8, 0}}}});
  const wire::WayBack way = way_back.way(corrections, kNear);
  EXPECT_NEAR(way.distance, 4, 1e-9);
  EXPECT_NEAR(way.sigma, 1, 1e-9);
  EXPECT_NEAR(std::abs(way.turn), pi, 1e-9);
  const auto here = way_back.reckoned(corrections);
  ASSERT_TRUE(here);
  EXPECT_NEAR((*here - Vector2d(7, 8)).norm(), 4, 1e-9);
}

// The camera is covered while the vehicle swims on.
TEST(WayBack, OfASimulatedDiveAgreesWithTheTruth) {
  simulate::Options options;
  options.stereo = true;
  options.images = 12;
  options.image_scale = 0.5;
  const simulate::Survey survey(options);
  reference::SurveyFrame survey_frame({}, [](const Window& window) {
    return plane::fit_plane(window.tie_points, window.images, {}).plane;
  });
  odometry::VisualOdometry engine({}, [&](const Window& initial, const auto& frames) {
    return survey_frame.place(initial, frames);
  });
  WayBack way_back(kEnough);
  constexpr int kCovered = 10;
  for (int i = 0; i < options.images; ++i) {
    Frame frame = survey.frame(i);
    if (i >= kCovered) {
      for (cv::Mat* picture : {&frame.colour, &frame.grey, &frame.right})
        *picture = cv::Mat::zeros(picture->size(), picture->type());
    }
    auto shot = std::make_shared<Shot>();
    shot->image = frame.image;
    shot->time = frame.time;
    shot->frame = std::make_shared<const Frame>(frame);
    Orientation orientation = engine.process(shot);
    (void)survey_frame.observe(orientation);
    orientation.dead_reckoned = survey_frame.dead_reckon(orientation);
    observe(way_back, orientation);
    EXPECT_EQ(way_back.is_lost(), i >= kCovered);
    if (i < kCovered) continue;
    const wire::WayBack way = way_back.way({}, 1.8);  // of the width of an image
    ASSERT_TRUE(way.known);
    const Rigid3 here = survey.survey_from_camera(i);
    const Vector2d to_view =
        (survey.survey_from_camera(kCovered - 1).translation - here.translation).head<2>();
    const Eigen::Vector3d top = here.rotation * -Eigen::Vector3d::UnitY();
    const double turn = std::atan2(to_view.x(), to_view.y()) - std::atan2(top.x(), top.y());
    EXPECT_NEAR(way.distance, to_view.norm(), 2 * way.sigma);
    EXPECT_NEAR(angle_between(way.turn, turn), 0, std::atan2(2 * way.sigma, to_view.norm()));
    EXPECT_LT(std::abs(angle_between(way.turn, turn)), 0.5);
  }
}

}  // namespace
}  // namespace nadir::app
