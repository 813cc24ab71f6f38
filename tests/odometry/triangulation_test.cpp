// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "triangulation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

Rigid3 beside(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }

Bearing bearing(const Rigid3& camera_from_map, const Vector3d& x) {
  return {camera_from_map, *ray_of(camera_from_map * x)};
}

TEST(Triangulation, MeetsWhereTheRaysCross) {
  const Vector3d x(0.2, -0.1, 3);
  const std::array rays{bearing(beside(0), x), bearing(beside(0.5), x), bearing(beside(-1), x)};
  const auto found = triangulate(rays);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - x).norm(), 1e-9);
}

TEST(Triangulation, HasNoAnswerForParallelRays) {
  const std::array rays{Bearing{beside(0), {0, 0}}, Bearing{beside(1), {0, 0}}};
  EXPECT_FALSE(triangulate(rays));
}

TEST(Triangulation, HasNoAnswerBehindTheCameras) {
  const std::array rays{Bearing{beside(0), {-0.1, 0}}, Bearing{beside(1), {0.1, 0}}};
  EXPECT_FALSE(triangulate(rays));
}

TEST(Triangulation, HasNoAnswerForWhatIsNoNumber) {
  const std::array rays{Bearing{beside(0), {std::nan(""), 0}}, Bearing{beside(1), {0.1, 0}}};
  EXPECT_FALSE(triangulate(rays));
}

TEST(Triangulation, MeasuresTheIntersectionAngle) {
  EXPECT_NEAR(parallax(beside(0), beside(2), {1, 0, 1}), M_PI / 2, 1e-12);
}

}  // namespace
}  // namespace nadir::odometry
