// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "patch.hpp"

#include <gtest/gtest.h>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

cv::Mat seabed(double x, double y, double yaw = 0, double altitude = 1) {
  static const Ground ground(5);
  return ground.image(small_rig().left, looking_down(x, y, altitude, yaw), 1);
}

// The camera moved by d metres moves the ground by 300 d px.
TEST(Patch, IsFoundWithSubPixelPrecisionUnderOtherLight) {
  const cv::Mat first = seabed(0, 0);
  cv::Mat second = seabed(1.37 / 300, -0.61 / 300);
  second.convertTo(second, CV_8U, 0.7, 30);
  double squares = 0;
  int found = 0;
  for (int y = 40; y < 200; y += 20) {
    for (int x = 40; x < 280; x += 20) {
      const auto patch = cut_patch(first, {x, y});
      const auto wanted = warp_patch(*patch, Matrix2d::Identity());
      if (!wanted) continue;
      const auto sight = refine(*wanted, second, Vector2d(x - 1, y - 1));
      if (!sight || sight->correlation < 0.9) continue;
      squares += (sight->pixel - Vector2d(x - 1.37, y - 0.61)).squaredNorm();
      ++found;
    }
  }
  EXPECT_GT(found, 60);
  EXPECT_LT(std::sqrt(squares / found), 0.12);
}

TEST(Patch, IsFoundTurnedWhenTheTurnIsKnown) {
  const double yaw = 0.6;
  const cv::Mat first = seabed(0, 0), second = seabed(0, 0, yaw);
  Matrix2d turn;
  turn << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  const Vector2d centre(159.5, 119.5);
  int found = 0;
  for (int x = 120; x < 200; x += 10) {
    const auto wanted = warp_patch(*cut_patch(first, {x, 110}), turn);
    if (!wanted) continue;
    const Vector2d there = centre + turn * (Vector2d(x, 110) - centre);
    const Sight coarse = search(*wanted, second, there, 3);
    const auto sight = refine(*wanted, second, coarse.pixel);
    if (sight && (sight->pixel - there).norm() < 0.3) ++found;
  }
  EXPECT_GE(found, 7);
}

TEST(Patch, TakesAChangeOfShapeThatWasNotKnown) {
  const cv::Mat first = seabed(0, 0), second = seabed(0, 0, 0, 1 / 1.12);
  const Vector2d centre(159.5, 119.5);
  int found = 0;
  for (int x = 120; x < 200; x += 10) {
    const auto wanted = warp_patch(*cut_patch(first, {x, 110}), Matrix2d::Identity());
    if (!wanted) continue;
    const Vector2d there = centre + 1.12 * (Vector2d(x, 110) - centre);
    const auto sight = refine(*wanted, second, there + Vector2d(0.7, -0.5));
    if (sight && (sight->pixel - there).norm() < 0.25) ++found;
  }
  EXPECT_GE(found, 6);
}

TEST(Patch, HasNoTemplateWithoutTexture) {
  const cv::Mat even(100, 100, CV_8U, cv::Scalar(80));
  EXPECT_FALSE(warp_patch(*cut_patch(even, {50, 50}), Matrix2d::Identity()));
  cv::Mat edge(100, 100, CV_8U, cv::Scalar(80));
  edge.colRange(50, 100).setTo(120);
  EXPECT_FALSE(warp_patch(*cut_patch(edge, {50, 50}), Matrix2d::Identity()));
}

TEST(Patch, IsNotCutAtTheBorder) {
  const cv::Mat image = seabed(0, 0);
  EXPECT_FALSE(cut_patch(image, {3, 50}));
  EXPECT_FALSE(cut_patch(image, {50, 239}));
}

TEST(Patch, IsNotFoundOutsideTheImage) {
  const cv::Mat image = seabed(0, 0);
  const auto wanted = warp_patch(*cut_patch(image, {50, 50}), Matrix2d::Identity());
  ASSERT_TRUE(wanted);
  EXPECT_FALSE(refine(*wanted, image, {-20, 10}));
  EXPECT_FALSE(refine(*wanted, image, {std::nan(""), 10}));
  EXPECT_LT(correlation(*wanted, image, 500, 10), 0);
}

TEST(Patch, RefusesADegenerateWarp) {
  const auto patch = cut_patch(seabed(0, 0), {50, 50});
  EXPECT_FALSE(warp_patch(*patch, Matrix2d::Zero()));
  EXPECT_FALSE(warp_patch(*patch, Matrix2d::Constant(std::nan(""))));
}

}  // namespace
}  // namespace nadir::odometry
