// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/corrected.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace nadir::mosaic2d {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

const Similarity3 kCorrection{
    1.1,
    {Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vector3d(0.1, -0.3, 1).normalized())),
     {0.5, -0.2, 0.1}}};

Plane sloping() {
  Plane plane;
  plane.normal = Vector3d(0.2, -0.1, 1).normalized();
  plane.offset = -3;
  return plane;
}

Vector3d on_plane(const Plane& plane, const Vector2d& xy) {
  return {xy.x(), xy.y(), (plane.offset - plane.normal.head<2>().dot(xy)) / plane.normal.z()};
}

TEST(Corrected, PixelsOfThePlaneMoveWithIt) {
  const WorldFile world{0.01, 0, 0, -0.01, 2, 3};
  const WorldFile now = moved(world, sloping(), kCorrection);
  for (const Vector2d& pixel : {Vector2d(0, 0), Vector2d(300, 10), Vector2d(50, 700)}) {
    const Vector3d x = on_plane(sloping(), world(pixel.x(), pixel.y()));
    EXPECT_LT((now(pixel.x(), pixel.y()) - (kCorrection * x).head<2>()).norm(), 1e-12);
  }
}

TEST(Corrected, TheMovedPlaneHoldsTheMovedPoints) {
  MosaicGrid grid;
  grid.plane = sloping();
  const MosaicGrid now = moved(grid, kCorrection);
  for (const Vector2d& xy : {Vector2d(0, 0), Vector2d(4, -1), Vector2d(-2, 5)}) {
    EXPECT_NEAR(now.plane.distance(kCorrection * on_plane(sloping(), xy)), 0, 1e-12);
  }
}

TEST(Corrected, AnAlignedImageShowsTheGroundWhereItsWorldFileSays) {
  ProjectedImage image;
  image.bgra = cv::Mat(120, 200, CV_8UC4, cv::Scalar(40, 40, 40, 255));
  image.bgra.colRange(0, 30).setTo(cv::Scalar::all(0));  // not seen
  const Vector2d disc(130, 70);
  cv::circle(image.bgra, {130, 70}, 6, cv::Scalar(200, 200, 200, 255), cv::FILLED, cv::LINE_AA);
  image.world = moved({0.01, 0, 0, -0.01, 2, 3}, sloping(), kCorrection);
  const MosaicGrid grid =
      levelled(moved({0, 0, 0.01, {0.01, 0, 0, -0.01, 1, 5}, sloping()}, kCorrection));
  const ProjectedImage level = aligned(image, grid);
  // North up, on whole pixels of the raster.
  EXPECT_EQ(level.world.b, 0);
  EXPECT_EQ(level.world.d, 0);
  const double column = (level.world.c - grid.world.c) / grid.ground_sampling_distance;
  EXPECT_NEAR(column, std::round(column), 1e-9);
  // The disc's centre is where it was.
  double sum = 0;
  Vector2d centre = Vector2d::Zero();
  for (int row = 0; row < level.bgra.rows; ++row) {
    for (int c = 0; c < level.bgra.cols; ++c) {
      const auto& pixel = level.bgra.at<cv::Vec4b>(row, c);
      const double weight = pixel[3] == 255 ? std::max(0, pixel[0] - 40) : 0;
      sum += weight;
      centre += weight * level.world(c, row);
    }
  }
  ASSERT_GT(sum, 0);
  const Vector2d expected = image.world(disc.x(), disc.y());
  EXPECT_LT((centre / sum - expected).norm(), 0.1 * grid.ground_sampling_distance);
  // What was not seen is not made up.
  const double back = 15.0;
  const Vector2d unseen = image.world(back, 60);
  const int c = static_cast<int>(std::lround((unseen.x() - level.world.c) / level.world.a));
  const int r = static_cast<int>(std::lround((unseen.y() - level.world.f) / level.world.e));
  EXPECT_EQ(level.bgra.at<cv::Vec4b>(r, c)[3], 0);
}

}  // namespace
}  // namespace nadir::mosaic2d
