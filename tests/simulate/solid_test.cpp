// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "solid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Quaterniond, Eigen::Vector3d;

TEST(Solid, ASmoothBlobIsAnEllipsoid) {
  const Solid ball =
      make_blob(Material::rock, {1, 2, 3}, {0.5, 0.4, 0.3}, Quaterniond::Identity(), 0, 1, 7);
  const auto hit = ball.hit({{1, 2, 10}, {0, 0, -2}});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 3.35, 1e-12);  // (10 - 3.3) / 2
  EXPECT_NEAR((hit->normal - Vector3d::UnitZ()).norm(), 0, 1e-12);
  EXPECT_FALSE(ball.hit({{1.51, 2, 10}, {0, 0, -1}}));
  EXPECT_FALSE(ball.hit({{1, 2, 10}, {0, 0, 1}}));
}

TEST(Solid, ASlabShowsItsTopAndItsSides) {
  const Rigid3 pose{Quaterniond::Identity(), {0, 0, 0.2}};
  const Solid slab = make_slab(Material::box, pose, {0.5, 0.3, 0.1}, 7);
  const auto top = slab.hit({{0.49, 0.29, 1}, {0, 0, -1}});
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->t, 0.8, 1e-12);
  EXPECT_NEAR(top->place.z(), 0, 1e-12);
  const auto side = slab.hit({{2, 0, 0.15}, {-1, 0, 0}});
  ASSERT_TRUE(side);
  EXPECT_NEAR(side->t, 1.5, 1e-12);
  EXPECT_NEAR((side->normal - Vector3d::UnitX()).norm(), 0, 1e-12);
  EXPECT_FALSE(slab.hit({{2, 0, 0.05}, {-1, 0, 0}}));
}

// Two eyes must agree where a rough surface is, or stereo truth is worthless.
TEST(Solid, ARoughBlobIsAtTheSamePlaceFromEverywhere) {
  constexpr double kSame = 1e-4;  // metres: 0.05 px at 2 m with 1000 px focal length
  Solid rock =
      make_blob(Material::coral, {0, 0, 0}, {0.4, 0.3, 0.2}, Quaterniond::Identity(), 0.15f, 3, 11);
  Random random(2);
  int seen = 0, agreed = 0, behind = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d left(random.uniform(-1, 1), random.uniform(-1, 1), 2);
    const Vector3d right = left + Vector3d(0.12, 0.03, 0.02);
    const Vector3d towards(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), 0);
    const auto first = rock.hit({left, towards - left});
    if (!first) continue;
    const Vector3d place = left + first->t * (towards - left);
    const auto second = rock.hit({right, place - right});
    ASSERT_TRUE(second);
    const double gap = (second->t - 1) * (place - right).norm();
    ++seen;
    agreed += std::abs(gap) < kSame;
    behind += gap >= kSame;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(agreed, 0.97 * seen);   // the rest is hidden by a bump,
  EXPECT_LT(behind, 0.003 * seen);  // or grazed
}

}  // namespace
}  // namespace nadir::simulate
