// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "guide.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/core/mat.hpp>
#include <thread>

#include "app/flat_seabed.hpp"
#include "nadir/image_io/decode.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector2d;

constexpr double kHeight = 2;  // images of 2 m by 1.5 m

/// A dive along a way, an image a second; what the page was told so far.
class Diver {
 public:
  explicit Diver(const Config& config = {}) : guide(config) {}

  void see(double x, double y, double heading = 0) {
    const Rigid3 pose = looking_down_at(x, y, kHeight, heading);
    const Orientation orientation = seen_from(image_, static_cast<double>(image_), pose, scale);
    const wire::LiveImage live{image_, orientation.shot->time, {1}};
    guide.observe(orientation, &live);
    take(guide.tell(now));
    guide.observe(ground_of(image_, pose));
    take(guide.tell(now));
    ++image_;
    now += 1s;
  }
  void swim(const Vector2d& from, const Vector2d& to) {
    const Vector2d way = to - from;
    const int steps = static_cast<int>(std::round(way.norm() / 0.5));
    const double heading = std::atan2(way.x(), way.y());
    for (int i = 0; i <= steps; ++i) {
      const Vector2d at = from + way * i / steps;
      see(at.x(), at.y(), heading);
    }
  }
  void take(Guide::Told told) {
    guidances += told.guidance ? 1 : 0;
    if (told.guidance) guidance = told.guidance;
    if (told.measures) measures = told.measures;
    if (told.way_back) way_back = told.way_back;
    if (told.last_view) last_view = told.last_view;
    for (wire::CoverageTile& tile : told.tiles) {
      ++sent;
      tiles[{tile.column, tile.row}] = std::move(tile);
    }
  }
  int pixel_at(double x, double y) const {
    const double cell = tiles.begin()->second.cell;
    const int column = static_cast<int>(std::floor(x / cell));
    const int row = static_cast<int>(std::floor(-y / cell));
    const std::pair place(static_cast<int>(std::floor(column / 64.0)),
                          static_cast<int>(std::floor(row / 64.0)));
    if (!tiles.contains(place)) return 0;
    const auto decoded = image_io::decode(tiles.at(place).png, 64, 64, 1, image_io::Colour::grey);
    return decoded.image.at<std::uint8_t>(row - 64 * place.second, column - 64 * place.first);
  }

  Guide guide;
  Guide::Clock::time_point now{1h};
  Scale scale{ScaleSource::stereo, 0.001};
  std::optional<wire::Guidance> guidance;
  std::optional<wire::Measures> measures;
  std::optional<wire::WayBack> way_back;
  std::optional<wire::LastView> last_view;
  std::map<std::pair<int, int>, wire::CoverageTile> tiles;
  int sent = 0, guidances = 0;

 private:
  std::uint64_t image_ = 0;
};

TEST(Guide, TellsWhatWasSeenAndTheGapsFromTheVehicle) {
  Diver diver;
  for (const double x : {0.0, 2.8, 4.2, 7.0})
    diver.swim({x, 0}, {x, 8});  // 1.4 apart, two left out
  diver.see(7, 8);
  ASSERT_TRUE(diver.guidance);
  EXPECT_TRUE(diver.guidance->plan.empty());
  ASSERT_EQ(diver.guidance->gaps.size(), 2u);
  EXPECT_NEAR(diver.guidance->gaps[0].centre.x(), 5.6, 0.2);
  EXPECT_NEAR(diver.guidance->gaps[1].centre.x(), 1.4, 0.2);
  EXPECT_NEAR(diver.guidance->gaps[0].area, 0.8 * 9.5, 0.5);
  EXPECT_NEAR(diver.guidance->area, 9 * 9.5, 0.5);
  EXPECT_NEAR(diver.guidance->covered, 9 * 9.5 - 2 * 0.8 * 9.5, 0.5);
  diver.swim({0, 8}, {0, 8.5});
  EXPECT_NEAR(diver.guidance->gaps[0].centre.x(), 1.4, 0.2);
  EXPECT_EQ(diver.pixel_at(1.4, 4), 128);
  EXPECT_EQ(diver.pixel_at(0, 0) & 128, 128);
  EXPECT_GT(diver.pixel_at(0, 4), 128 + 2);
  EXPECT_EQ(diver.pixel_at(30, 30), 0);
}

TEST(Guide, SendsTilesThatChangedOnceASecond) {
  Diver diver;
  diver.swim({0, 0}, {0, 20});
  const auto tiles = static_cast<int>(diver.tiles.size());
  EXPECT_LT(diver.sent, 10 * tiles);  // a tile is in view of some six images
  const int before = diver.sent, told = diver.guidances;
  for (int i = 0; i < 100; ++i) {
    diver.now += 10ms;
    diver.guide.observe(seen_from(99, 99, looking_down_at(0, 20, kHeight)), nullptr);
    diver.take(diver.guide.tell(diver.now));
  }
  EXPECT_EQ(diver.sent, before);
  EXPECT_LE(diver.guidances - told, 2);
  diver.take(diver.guide.finish());
  EXPECT_EQ(diver.sent, before);
}

Config planned_config() {
  Config config;
  config.plan = {.length = 10, .width = 6, .bearing_deg = 90, .lane_spacing = 1.5};
  config.plan.corner_y = 6;  // lanes to the east, the first along y = 5.25
  return config;
}

TEST(Guide, FollowsThePlansLanes) {
  Diver diver(planned_config());
  diver.swim({0, 5.25}, {4, 5.25});
  ASSERT_TRUE(diver.guidance);
  EXPECT_EQ(diver.guidance->plan.size(), 4u);
  ASSERT_EQ(diver.guidance->lanes.size(), 4u);
  EXPECT_DOUBLE_EQ(diver.guidance->area, 60);
  EXPECT_EQ(diver.guidance->lane, 0);
  EXPECT_NEAR(diver.guidance->off_lane, 0, 1e-6);
  EXPECT_NEAR(diver.guidance->lanes[0].covered, 0.5, 0.06);
  diver.swim({4.5, 5.05}, {10, 5.05});
  EXPECT_NEAR(diver.guidance->off_lane, 0.2, 1e-6);
  EXPECT_GT(diver.guidance->lanes[0].covered, 0.97);
  diver.swim({10, 3.75}, {6, 3.75});
  EXPECT_EQ(diver.guidance->lane, 1);
  EXPECT_LT((diver.guidance->lanes[1].from - Vector2d(10, 3.75)).norm(), 1e-9);
  ASSERT_EQ(diver.guidance->gaps.size(), 1u);
  EXPECT_NEAR(diver.guidance->gaps[0].area, 60 - diver.guidance->covered, 0.5);
}

TEST(Guide, TellsOfAnotherLaneAtOnce) {
  Diver diver(planned_config());
  diver.swim({0, 5.25}, {4, 5.25});
  const int told = diver.guidances;
  diver.now -= 900ms;
  diver.see(4.5, 7.5);  // off to the left
  EXPECT_EQ(diver.guidances, told + 1);
  EXPECT_FALSE(diver.guidance->lane);
}

TEST(Guide, WaitsForAScaleBeforeItPlans) {
  Diver diver(planned_config());
  diver.scale = {};
  diver.swim({0, 5.25}, {2, 5.25});
  EXPECT_TRUE(diver.guidance->plan.empty());
  Revision revision;
  revision.corrections.push_back({0, 0, {1.1, {}}});
  revision.scales.emplace_back(0, Scale{ScaleSource::laser, 0.01});
  diver.guide.observe(revision);
  diver.see(2.5, 5.25);
  EXPECT_EQ(diver.guidance->plan.size(), 4u);
}

TEST(Guide, TakesAnotherPlanWhileItRuns) {
  Diver diver;
  diver.swim({0, 0}, {0, 3});
  EXPECT_TRUE(diver.guidance->lanes.empty());
  std::jthread([&] { diver.guide.plan(coverage::Plan{{-1, 0}, 10, 4, 0, 0}); }).join();
  diver.see(0, 3.5);
  ASSERT_EQ(diver.guidance->plan.size(), 4u);
  EXPECT_EQ(diver.guidance->lanes.size(), 3u);  // 0.7 of 2 m apart at most
  EXPECT_EQ(diver.pixel_at(2.9, 9.9), 128);
  diver.guide.plan({});
  diver.see(0, 4);
  diver.see(0, 4.5);
  EXPECT_TRUE(diver.guidance->plan.empty());
  EXPECT_EQ(diver.pixel_at(2.9, 9.9), 0);
}

TEST(Guide, MovesWhatACorrectionMoves) {
  Diver diver;
  diver.swim({0, 0}, {0, 2});
  EXPECT_GT(diver.pixel_at(0.1, 1), 128);
  Revision revision;
  revision.corrections.push_back({0, 0, {1, {Eigen::Quaterniond::Identity(), {20, 0, 0}}}});
  diver.guide.observe(revision);
  diver.see(0, 2.5);
  EXPECT_EQ(diver.pixel_at(0.1, 1), 0);
  EXPECT_GT(diver.pixel_at(20.1, 1), 128);
}

TEST(Guide, LeadsBackWhileTrackingIsLost) {
  Diver diver;
  diver.swim({0, 0}, {0, 2});
  EXPECT_FALSE(diver.way_back);
  Orientation lost = seen_from(90, 90, {});
  lost.state = TrackingState::lost;
  lost.poses.clear();
  lost.window.reset();
  lost.dead_reckoned = DeadReckoned{90, 0, looking_down_at(0, 5, kHeight), 0.5};
  diver.guide.observe(lost, nullptr);
  diver.take(diver.guide.tell(diver.now));
  ASSERT_TRUE(diver.way_back && diver.last_view);
  EXPECT_TRUE(diver.way_back->lost && diver.way_back->known);
  EXPECT_NEAR(diver.way_back->distance, 3, 1e-6);
  EXPECT_EQ(diver.last_view->image, 4u);
  diver.see(0, 2.5);
  EXPECT_FALSE(diver.way_back->lost);
}

TEST(Guide, TellsTheDialsFiveTimesASecond) {
  Diver diver;
  diver.guide.note({.battery = 0.4});
  diver.guide.watch_disk(".");
  int told = 0;
  for (std::uint64_t i = 0; i < 40; ++i, diver.now += 50ms) {
    const Rigid3 pose = looking_down_at(0, 0.02 * static_cast<double>(i), kHeight);
    diver.guide.observe(seen_from(i, 0.05 * static_cast<double>(i), pose), nullptr);
    Guide::Told record = diver.guide.tell(diver.now);
    told += record.measures ? 1 : 0;
    diver.take(std::move(record));
  }
  EXPECT_EQ(told, 10);
  std::map<wire::Quantity, double> values;
  for (const auto& measure : diver.measures->measures) values[measure.quantity] = measure.value;
  EXPECT_EQ(values.at(wire::Quantity::battery), 0.4);
  EXPECT_GT(values.at(wire::Quantity::free_space), 0);
  EXPECT_NEAR(values.at(wire::Quantity::speed), 0.4, 1e-6);
}

}  // namespace
}  // namespace nadir::app
