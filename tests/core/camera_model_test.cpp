// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/camera_model.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

namespace nadir {
namespace {

CameraModel wide_lens() {
  return {968,
          728,
          918.2,
          917.4,
          479.6,
          367.9,
          LensModel::brown_conrady,
          {-0.108, 0.089, -5e-4, 6e-4, -0.015}};
}

CameraModel fisheye_lens() {
  return {800, 600, 420, 421, 399, 302, LensModel::kannala_brandt, {0.02, -0.01, 0.004, -0.001}};
}

cv::Point2d opencv_projection(const CameraModel& c, const cv::Point3d& x) {
  const cv::Matx33d k(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  if (c.lens == LensModel::brown_conrady) {
    cv::projectPoints(std::vector{x}, cv::Vec3d(), cv::Vec3d(), k, c.distortion, pixels);
  } else {
    const cv::Vec4d d(c.distortion[0], c.distortion[1], c.distortion[2], c.distortion[3]);
    cv::fisheye::projectPoints(std::vector{x}, pixels, cv::Vec3d(), cv::Vec3d(), k, d);
  }
  return pixels.front();
}

class Lens : public testing::TestWithParam<CameraModel> {};
INSTANTIATE_TEST_SUITE_P(Both, Lens, testing::Values(wide_lens(), fisheye_lens()));

TEST_P(Lens, ProjectsAsOpenCvDoes) {
  for (double x = -0.5; x <= 0.5; x += 0.125) {
    for (double y = -0.4; y <= 0.4; y += 0.1) {
      const auto pixel = GetParam().project({2 * x, 2 * y, 2});
      ASSERT_TRUE(pixel);
      const cv::Point2d expected = opencv_projection(GetParam(), {2 * x, 2 * y, 2});
      EXPECT_NEAR(pixel->x(), expected.x, 1e-9);
      EXPECT_NEAR(pixel->y(), expected.y, 1e-9);
    }
  }
}

TEST_P(Lens, UnprojectsEveryPixelItProjects) {
  const CameraModel& camera = GetParam();
  for (int u = 0; u < camera.width; u += 37) {
    for (int v = 0; v < camera.height; v += 29) {
      const auto ray = camera.unproject({u, v});
      ASSERT_TRUE(ray) << u << ' ' << v;
      const auto pixel = camera.project({3 * ray->x(), 3 * ray->y(), 3});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR((*pixel - Eigen::Vector2d(u, v)).norm(), 0, 1e-6);
    }
  }
}

TEST(CameraModel, RefusesPointsBehindTheCameraAndBeyondTheFold) {
  CameraModel folding = wide_lens();
  folding.distortion = {-0.5, 0, 0, 0, 0};  // r (1 - r^2 / 2) turns back at r = 0.816
  EXPECT_FALSE(folding.project({0, 0, -1}));
  EXPECT_FALSE(folding.project({0, 0, 0}));
  EXPECT_TRUE(folding.project({0.7, 0, 1}));
  EXPECT_FALSE(folding.project({0.9, 0, 1}));
}

TEST(CameraModel, ReducedKeepsRaysOfPixelAreas) {
  const CameraModel camera = wide_lens(), quarter = camera.reduced(4);
  EXPECT_EQ(quarter.width, 242);
  EXPECT_EQ(quarter.height, 182);
  // The centre of the area of pixels 40..43 is 41.5; it is pixel 10 of the reduced image.
  const auto full = camera.unproject({41.5, 81.5}), small = quarter.unproject({10, 20});
  ASSERT_TRUE(full && small);
  EXPECT_NEAR((*full - *small).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace nadir
