// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/footprint.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "nadir/coverage/polygon.hpp"

namespace nadir::coverage {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kColumns = 30, kRows = 20;
constexpr double kHeight = 2;

/// Of a camera at kHeight over z = 0, 1 rad wide (by its tangent), tilted ahead by so much.
Grid grid_of(double tilt, double max_range) {
  Grid grid;
  grid.image = 7;
  grid.submap = 2;
  grid.bgr = cv::Mat(kRows, kColumns, CV_8UC3);
  grid.camera_in_survey = {5, -3, kHeight};
  grid.max_range = max_range;
  Eigen::Matrix3d camera_from_grid;  // columns 1 / 30 wide
  camera_from_grid << 1, 0, -14.5, 0, 1, -9.5, 0, 0, kColumns;
  Eigen::Matrix3d survey_from_camera;
  survey_from_camera << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Eigen::Matrix3d tilted =
      survey_from_camera * Eigen::AngleAxisd(tilt, Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d rays = tilted * camera_from_grid;
  const Eigen::RowVector3d w = -rays.row(2);
  grid.survey_from_grid << kHeight * rays + grid.camera_in_survey * w, w;
  return grid;
}

Polygon flat(const Footprint& footprint) {
  Polygon polygon;
  for (const Vector3d& corner : footprint.corners) {
    EXPECT_NEAR(corner.z(), 0, 1e-9);
    polygon.emplace_back(corner.head<2>());
  }
  return polygon;
}

TEST(Footprint, IsTheGroundOfWholeCells) {
  const auto footprint = footprint_of(grid_of(0, 100));
  ASSERT_TRUE(footprint);
  EXPECT_EQ(footprint->image, 7u);
  EXPECT_EQ(footprint->submap, 2u);
  EXPECT_NEAR(footprint->width, kHeight, 1e-9);
  EXPECT_NEAR(footprint->length, kHeight * kRows / kColumns, 1e-9);
  const Polygon ground = flat(*footprint);
  ASSERT_EQ(ground.size(), 4u);
  EXPECT_NEAR(area(ground), kHeight * kHeight * kRows / kColumns, 1e-9);
  EXPECT_NEAR(ground[0].x(), 5 - kHeight / 2, 1e-9);
  EXPECT_NEAR(ground[0].y(), -3 + kHeight * kRows / kColumns / 2, 1e-9);
}

TEST(Footprint, EndsWhereTheCellsEnd) {
  const Grid grid = grid_of(0, 2.1);  // a circle of 0.64 around the foot
  const auto footprint = footprint_of(grid);
  ASSERT_TRUE(footprint);
  for (const Vector3d& corner : footprint->corners)
    EXPECT_LE((corner - grid.camera_in_survey).norm(), 2.1 + 1e-9);
  EXPECT_NEAR(area(flat(*footprint)), area(flat(*footprint_of(grid_of(0, 100)))) * 0.44, 0.15);
  // By its points, the cells are as many.
  const double cell = kHeight * kHeight / kColumns / kColumns;
  EXPECT_NEAR(area(flat(*footprint)), cell * static_cast<double>(grid.points().size()), 0.06);
}

TEST(Footprint, OfASlantedViewLeavesOutTheSky) {
  const Grid grid = grid_of(1.4, 12);
  const auto footprint = footprint_of(grid);
  ASSERT_TRUE(footprint);
  const Polygon ground = flat(*footprint);
  for (const CloudPoint& point : grid.points()) {
    const Vector2d at = point.x_in_survey.head<2>();
    // Within, or within a corner of the circle's polygon.
    const Polygon around{at + Vector2d(0.1, 0.1), at + Vector2d(-0.1, 0.1),
                         at + Vector2d(-0.1, -0.1), at + Vector2d(0.1, -0.1)};
    EXPECT_GT(area(clipped(around, ground)), 0);
  }
  for (const Vector2d& corner : ground)
    EXPECT_LE((Vector3d(corner.x(), corner.y(), 0) - grid.camera_in_survey).norm(), 12 + 1e-9);
}

TEST(Footprint, IsNoneWhereTheCentreShowsNothing) {
  EXPECT_FALSE(footprint_of(grid_of(0, 1.9)));
  EXPECT_FALSE(footprint_of(grid_of(1.6, 100)));
}

TEST(Footprint, PolygonsAreClippedEitherWayRound) {
  const Polygon square{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  Polygon other{{1, 1}, {3, 1}, {3, 3}, {1, 3}};
  EXPECT_NEAR(area(clipped(square, other)), 1, 1e-12);
  std::ranges::reverse(other);
  EXPECT_NEAR(area(clipped(square, other)), 1, 1e-12);
  EXPECT_TRUE(clipped(square, {{5, 5}, {6, 5}, {6, 6}}).empty());
}

}  // namespace
}  // namespace nadir::coverage
