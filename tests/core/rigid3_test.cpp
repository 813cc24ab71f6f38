// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/rigid3.hpp"

#include <gtest/gtest.h>

namespace nadir {
namespace {

const Rigid3 b_from_a{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3}};
const Rigid3 c_from_b{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                      {-4, 0, 1}};
const Eigen::Vector3d x_in_a(0.2, -7, 5);

TEST(Rigid3, ComposesAsAppliedInTurn) {
  EXPECT_NEAR(((c_from_b * b_from_a) * x_in_a - c_from_b * (b_from_a * x_in_a)).norm(), 0, 1e-12);
}

TEST(Rigid3, InverseUndoes) {
  EXPECT_NEAR((b_from_a.inverse() * (b_from_a * x_in_a) - x_in_a).norm(), 0, 1e-12);
}

TEST(Similarity3, MovesCamerasWithTheirPoints) {
  const Similarity3 map{2.5, c_from_b};
  const Rigid3 moved = map * b_from_a;
  // A point seen by the camera keeps its direction; its distance grows by the scale.
  const Eigen::Vector3d seen = b_from_a.inverse() * x_in_a,
                        seen_after = moved.inverse() * (map * x_in_a);
  EXPECT_NEAR((seen_after - 2.5 * seen).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace nadir
