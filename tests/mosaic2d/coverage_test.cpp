// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/coverage.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nadir::mosaic2d {
namespace {

using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

Polygon box(double x, double y, double width, double height) {
  return {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
}

double area_of(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return std::abs(twice) / 2;
}

/// Of a coverage whose border is so long: a cell more or less along it.
double tolerance(const Coverage& coverage, double border) { return border * coverage.cell(); }

TEST(Coverage, IsTheUnionOfTheFootprints) {
  Coverage coverage;
  EXPECT_EQ(coverage.area(), 0);
  EXPECT_TRUE(coverage.outline().empty());
  coverage.add(box(-3, 2, 1, 0.8));
  EXPECT_NEAR(coverage.area(), 0.8, tolerance(coverage, 3.6));
  coverage.add(box(-2.5, 2, 1, 0.8));  // half of it is new
  EXPECT_NEAR(coverage.area(), 1.2, tolerance(coverage, 4.6));
  coverage.add(box(7, -9, 1, 0.8));  // far away, before the origin in y
  EXPECT_NEAR(coverage.area(), 2.0, tolerance(coverage, 8.2));
}

TEST(Coverage, OutlinesEachPatchWhereItLies) {
  Coverage coverage;
  coverage.add(box(-3, 2, 1, 0.8));
  coverage.add(box(7, -9, 2, 1));
  const auto outline = coverage.outline();
  ASSERT_EQ(outline.size(), 2u);
  for (const Polygon& polygon : outline) {
    const bool first = polygon[0].x() < 0;
    EXPECT_NEAR(area_of(polygon), first ? 0.8 : 2, tolerance(coverage, first ? 3.6 : 6));
    EXPECT_LE(polygon.size(), 8u);
    for (const Vector2d& corner : polygon) {
      EXPECT_GT(corner.x(), (first ? -3 : 7) - coverage.cell());
      EXPECT_LT(corner.x(), (first ? -2 : 9) + coverage.cell());
      EXPECT_GT(corner.y(), (first ? 2 : -9) - coverage.cell());
      EXPECT_LT(corner.y(), (first ? 2.8 : -8) + coverage.cell());
    }
  }
}

TEST(Coverage, OutlinesAHoleThatWasLeftOut) {
  Coverage coverage;
  for (const Polygon& side : {box(0, 0, 3, 1), box(0, 2, 3, 1), box(0, 0, 1, 3), box(2, 0, 1, 3)})
    coverage.add(side);
  const auto outline = coverage.outline();
  ASSERT_EQ(outline.size(), 2u);
  const double inner = std::min(area_of(outline[0]), area_of(outline[1]));
  EXPECT_NEAR(inner, 1, tolerance(coverage, 4));
  EXPECT_NEAR(coverage.area(), 8, tolerance(coverage, 16));
}

TEST(Coverage, StaysSmallOverALongWay) {
  Coverage coverage;
  constexpr int kImages = 5000;  // 2.5 km
  for (int i = 0; i < kImages; ++i) coverage.add(box(0.5 * i, 0.1 * i, 1, 0.8));
  EXPECT_GT(coverage.cell(), 1.0 / 32);
  const double length = std::hypot(0.5, 0.1) * kImages;
  EXPECT_NEAR(coverage.area(), 0.5 * kImages * 0.8, 2.2 * tolerance(coverage, 2 * length));
}

TEST(Coverage, LeavesOutFootprintsThatAreNone) {
  Coverage coverage;
  coverage.add(Polygon{{0, 0}, {1, 1}});
  coverage.add(Polygon{{0, 0}, {1, NAN}, {1, 1}});
  coverage.add(Polygon{{0, 0}, {1, 0}, {2, 0}});
  EXPECT_EQ(coverage.area(), 0);
}

}  // namespace
}  // namespace nadir::mosaic2d
