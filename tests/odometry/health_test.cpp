// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "health.hpp"

#include <gtest/gtest.h>

namespace nadir::odometry {
namespace {

using Eigen::Vector2d;

// Two key frames of a camera of 100 x 80 px and tie points at these pixels of the last, seen in so
// many key frames.
struct SmallMap {
  Map map;
  Resection resection;

  explicit SmallMap(const std::vector<std::pair<Vector2d, int>>& points) {
    CameraRig rig;
    rig.left = {100, 80, 100, 100, 49.5, 39.5, LensModel::brown_conrady, {}};
    map.rig = std::make_shared<const CameraRig>(rig);
    map.key_frames.resize(2);
    map.key_frames.back().rms_px = resection.rms_px = 0.5;
    resection.expected = 1;
    for (const auto& [pixel, images] : points) {
      const int index = static_cast<int>(map.points.size());
      const Vector2d ray = *rig.left.unproject(pixel);
      MapPoint point;
      point.sightings.assign(static_cast<std::size_t>(images), {0, ray, {}});
      if (images > 0) point.sightings.back() = {1, ray, {}};
      map.points.push_back(point);
      map.key_frames.back().points.push_back(index);
      resection.seen.push_back({index, pixel, ray});
    }
  }
  Health of_key_frame(const Config& config = {}) const {
    Health health;
    count(health, map, 1, config);
    return health;
  }
  Health of_resection(const Config& config = {}) const {
    Health health;
    count(health, map, resection, config);
    return health;
  }
};

const std::vector<std::pair<Vector2d, int>> kFour{
    {{10, 10}, 2}, {{90, 10}, 3}, {{10, 70}, 5}, {{90, 70}, 7}, {{80, 60}, 4}};

TEST(Health, CountsTiePointsByQuadrantAndTheMedianOfTheImagesThatSeeThem) {
  const Health health = SmallMap(kFour).of_key_frame();
  EXPECT_EQ(health.tie_points, 5u);
  EXPECT_EQ(health.by_quadrant, (std::array<std::uint32_t, 4>{1, 1, 1, 2}));
  EXPECT_EQ(health.tracked_length, 4);
  EXPECT_EQ(health.rms_px, 0.5);
}

// A tie point that an image between key frames sees was seen in one image more.
TEST(Health, OfAnImageBetweenKeyFramesCountsTheImageItself) {
  const Health health = SmallMap(kFour).of_resection();
  EXPECT_EQ(health.tie_points, 5u);
  EXPECT_EQ(health.by_quadrant, (std::array<std::uint32_t, 4>{1, 1, 1, 2}));
  EXPECT_EQ(health.tracked_length, 5);
}

TEST(Health, IsWeakByTheThresholds) {
  const SmallMap map(kFour);
  Config config;
  config.weak_tie_points = 5;
  config.weak_quadrant = 1;
  config.weak_track_length = 4;
  config.weak_rms_px = 0.5;
  EXPECT_EQ(map.of_key_frame(config).weaknesses, 0);
  config.weak_tie_points = 6;
  EXPECT_TRUE(map.of_key_frame(config).has(Weakness::few_tie_points));
  config.weak_quadrant = 2;
  EXPECT_TRUE(map.of_key_frame(config).has(Weakness::one_sided));
  config.weak_track_length = 5;
  EXPECT_TRUE(map.of_key_frame(config).has(Weakness::short_tracks));
  config.weak_rms_px = 0.4;
  EXPECT_TRUE(map.of_key_frame(config).has(Weakness::large_residuals));
}

TEST(Health, OfNothingIsWeak) {
  const Health health = SmallMap({}).of_resection();
  EXPECT_EQ(health.tracked_length, 0);
  EXPECT_TRUE(health.has(Weakness::few_tie_points));
}

}  // namespace
}  // namespace nadir::odometry
