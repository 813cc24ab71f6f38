// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Quaterniond, Eigen::Vector2d, Eigen::Vector3d;

constexpr double kHeadingOff = 0.2, kHeightOff = 7.5, kRangeOff = 0.03;

Quaterniond about_up(double angle) {
  return Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
}

// A metric map of one camera over flat ground 1.5 below, whose sensors are off by constants.
Map metric_map(int key_frames) {
  Map map;
  map.rig = std::make_shared<const CameraRig>(small_rig());
  map.axes = SurveyAxes::attitude;
  map.scale = {ScaleSource::laser, 0.01};
  for (int k = 0; k < key_frames; ++k) {
    const Rigid3 pose = looking_down(0.2 * k, 0, 1.5, 0.1 * k, 0.02);
    KeyFrame key_frame;
    key_frame.camera_from_map = pose.inverse();
    key_frame.enu_from_camera = about_up(-kHeadingOff) * pose.rotation;
    key_frame.height = pose.translation.z() - kHeightOff;
    const double depth = 1.5 * std::exp(-kRangeOff);
    key_frame.ranges = {{Vector2d(0.02, 0), depth, 0.004}};
    map.key_frames.push_back(key_frame);
    MapPoint point;
    point.x = pose * Vector3d(0.03, 0.01, 1.5);
    point.sightings = {{k, Vector2d(0.02, 0.0067), {}}};
    map.key_frames.back().points = {k};
    map.points.push_back(point);
  }
  return map;
}

Adjustment of_all(const Map& map, std::vector<int>& key_frames, std::vector<int>& points) {
  Adjustment a;
  for (int k = 0; k < static_cast<int>(map.key_frames.size()); ++k) {
    a.images.push_back({map.key_frame(k).camera_from_map, k == 0, false});
    a.points.push_back({map.point(k).x, false});
    key_frames.push_back(k);
    points.push_back(k);
  }
  return a;
}

TEST(SensorFactors, SayNothingBeforeTheirOffsetsAreKnown) {
  const Map map = metric_map(4);
  std::vector<int> key_frames, points;
  Adjustment a = of_all(map, key_frames, points);
  add_sensor_factors(map, key_frames, points, Config(), a);
  EXPECT_EQ(a.verticals.size(), 4U);  // only their differences count
  EXPECT_TRUE(a.headings.empty() && a.heights.empty() && a.ranges.empty());
}

TEST(SensorFactors, SayWhatTheMapHasOnceTheirOffsetsAreLearned) {
  Map map = metric_map(30);
  for (int k = 0; k < 25; ++k) learn_offsets(map, map.key_frame(k), k);
  EXPECT_NEAR(map.heading_offset.mean(), kHeadingOff, 1e-9);
  EXPECT_NEAR(map.height_offset.mean(), kHeightOff, 1e-9);
  EXPECT_NEAR(map.range_offset.mean(), kRangeOff, 1e-9);
  std::vector<int> key_frames, points;
  Adjustment a = of_all(map, key_frames, points);
  add_sensor_factors(map, key_frames, points, Config(), a);
  ASSERT_EQ(a.headings.size(), 29U);  // the first image is held
  ASSERT_EQ(a.heights.size(), 29U);
  ASSERT_EQ(a.ranges.size(), 29U);
  for (std::size_t i = 0; i < 29; ++i) {
    const Rigid3 pose = map.key_frames[i + 1].camera_from_map.inverse();
    EXPECT_LT(a.headings[i].map_from_camera.angularDistance(pose.rotation), 1e-7);
    EXPECT_NEAR(a.heights[i].z, pose.translation.z(), 1e-9);
    EXPECT_NEAR(a.ranges[i].depth, 1.5, 1e-9);
    EXPECT_EQ(a.ranges[i].point, static_cast<int>(i) + 1);
  }
}

TEST(SensorFactors, OfAnUnscaledMapTakeNoMetres) {
  Map map = metric_map(30);
  map.scale = {};
  for (int k = 0; k < 25; ++k) learn_offsets(map, map.key_frame(k), k);
  std::vector<int> key_frames, points;
  Adjustment a = of_all(map, key_frames, points);
  add_sensor_factors(map, key_frames, points, Config(), a);
  EXPECT_EQ(a.headings.size(), 29U);
  EXPECT_TRUE(a.heights.empty() && a.ranges.empty());
}

// The offset follows a compass that wanders, some hundred key frames behind, and not its noise.
TEST(SensorFactors, FollowASlowlyVaryingOffset) {
  SlowOffset offset;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.05);
  for (int k = 0; k < 1000; ++k) offset.add(1e-4 * k + noise(random));
  EXPECT_NEAR(offset.mean(), 1e-4 * (1000 - 200), 3 * 0.05 / std::sqrt(2.0 * 200));
}

}  // namespace
}  // namespace nadir::odometry
