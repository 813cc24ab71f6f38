// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/depth_prior.hpp"

#include <gtest/gtest.h>

namespace nadir::odometry {
namespace {

std::vector<DepthSample> tilted_plane() {
  std::vector<DepthSample> samples;
  for (int i = -5; i <= 5; ++i) {
    for (int k = -5; k <= 5; ++k) {
      const Eigen::Vector2d ray(0.1 * i, 0.1 * k);
      samples.push_back({ray, 0.5 + 0.2 * ray.x() - 0.1 * ray.y()});
    }
  }
  return samples;
}

TEST(DepthPrior, ContinuesAPlane) {
  const DepthPrior prior(tilted_plane());
  ASSERT_TRUE(prior.known());
  EXPECT_NEAR(prior.at({0.7, 0.3}).inverse_depth, 0.5 + 0.14 - 0.03, 1e-6);
  EXPECT_LT((prior.normal() - Eigen::Vector3d(0.2, -0.1, 0.5).normalized()).norm(), 1e-6);
}

TEST(DepthPrior, FollowsReliefInTheNeighbourhood) {
  auto samples = tilted_plane();
  for (auto& s : samples) {
    if ((s.ray - Eigen::Vector2d(0.4, 0.4)).norm() < 0.25) s.inverse_depth += 0.1;
  }
  const DepthPrior prior(samples);
  EXPECT_NEAR(prior.at({0.42, 0.4}).inverse_depth, 0.5 + 0.084 - 0.04 + 0.1, 0.02);
}

TEST(DepthPrior, SearchesWiderFarFromWhatIsKnown) {
  auto samples = tilted_plane();
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].inverse_depth += i % 2 == 0 ? 0.03 : -0.03;
  const DepthPrior prior(samples);
  EXPECT_GT(prior.at({0.95, 0}).spread, prior.at({0.95, 0}).inverse_depth * 0.1);
}

TEST(DepthPrior, IsUnknownWithTooFewOrSenselessSamples) {
  EXPECT_FALSE(DepthPrior({}).known());
  EXPECT_FALSE(DepthPrior({{{0, 0}, 1}, {{0.1, 0}, 1}}).known());
  EXPECT_FALSE(DepthPrior(std::vector<DepthSample>(20, {{0, 0}, -1})).known());
}

}  // namespace
}  // namespace nadir::odometry
