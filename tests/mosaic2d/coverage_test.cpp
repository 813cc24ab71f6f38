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
    const double cell = 1.001 * coverage.cell();
    for (const Vector2d& corner : polygon) {
      EXPECT_GT(corner.x(), (first ? -3 : 7) - cell);
      EXPECT_LT(corner.x(), (first ? -2 : 9) + cell);
      EXPECT_GT(corner.y(), (first ? 2 : -9) - cell);
      EXPECT_LT(corner.y(), (first ? 2.8 : -8) + cell);
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

/// Counts what OpenCV's images take.
class CountingAllocator : public cv::MatAllocator {
 public:
  CountingAllocator() { cv::Mat::setDefaultAllocator(this); }
  ~CountingAllocator() override { cv::Mat::setDefaultAllocator(cv::Mat::getStdAllocator()); }
  CountingAllocator(const CountingAllocator&) = delete;
  CountingAllocator& operator=(const CountingAllocator&) = delete;

  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                         cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    cv::UMatData* const made =
        cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
    made->prevAllocator = made->currAllocator = this;
    used_ += made->size;
    most_ = std::max(most_, used_);
    return made;
  }
  bool allocate(cv::UMatData* data, cv::AccessFlag, cv::UMatUsageFlags) const override {
    return data != nullptr;
  }
  void deallocate(cv::UMatData* data) const override {
    used_ -= data->size;
    cv::Mat::getStdAllocator()->deallocate(data);
  }
  std::size_t most() const { return most_; }

 private:
  mutable std::size_t used_ = 0, most_ = 0;
};

TEST(Coverage, TakesLittleMemoryOverALargeSurvey) {
  const CountingAllocator memory;
  Coverage coverage;
  constexpr double kLength = 500, kApart = 2.5, kWide = 1, kHigh = 0.8;
  constexpr int kLegs = 160;
  for (int leg = 0; leg < kLegs; ++leg) {
    for (double along = 0; along + kHigh <= kLength; along += kHigh / 2)
      coverage.add(box(kApart * leg, leg % 2 == 0 ? along : kLength - kHigh - along, kWide, kHigh));
  }
  EXPECT_LT(coverage.cell(), kWide / 4);  // the ground between the legs is told apart
  const double border = kLegs * 2 * (kLength + kWide);
  EXPECT_NEAR(coverage.area(), kLegs * kWide * kLength, tolerance(coverage, border));
  const auto outline = coverage.outline();
  EXPECT_EQ(outline.size(), static_cast<std::size_t>(kLegs));
  for (const Polygon& leg : outline)
    EXPECT_NEAR(area_of(leg), kWide * kLength, tolerance(coverage, 2 * (kLength + kWide)));
  EXPECT_LT(memory.most(), 16'000'000u);
}

TEST(Coverage, TakesLittleMemoryWhateverComes) {
  const CountingAllocator memory;
  Coverage coverage;
  for (const double far : {1.0, 30.0, 79.0, 200.0, 1e3, 1e6, 1e9}) {
    for (const Vector2d& at : {Vector2d(far, 0), {-far, far}, {0, -far}})
      coverage.add(box(at.x(), at.y(), 1, 1));
    coverage.add(box(-far, -far, far, far));
    EXPECT_FALSE(coverage.outline().empty());
  }
  EXPECT_LT(memory.most(), 16'000'000u);
}

TEST(Coverage, KeepsAllGroundWhenItIsMadeCoarser) {
  Coverage coverage;
  for (int i = 0; i < 100; ++i) coverage.add(box(2 * (i % 10), 2 * (i / 10), 1, 1));
  EXPECT_EQ(coverage.outline().size(), 100u);
  double area = coverage.area();
  for (int i = 0; i < 20; ++i) {
    coverage.coarsen();
    EXPECT_GE(coverage.area(), area);
    area = coverage.area();
    double outlined = 0;
    for (const Polygon& polygon : coverage.outline()) outlined += area_of(polygon);
    EXPECT_GE(outlined, 100) << i;
  }
  ASSERT_EQ(coverage.outline().size(), 1u);
  EXPECT_EQ(coverage.outline()[0].size(), 4u);
}

TEST(Coverage, OutlinesASlantingWayByItsCorners) {
  Coverage coverage;
  const Vector2d along = Vector2d(1, 0.2).normalized(), across(-along.y(), along.x());
  for (double s = 0; s < 20; s += 0.25) {
    Polygon footprint;
    for (const Vector2d& corner : box(s, 0, 1, 0.8))
      footprint.push_back(corner.x() * along + corner.y() * across);
    coverage.add(footprint);
  }
  const auto outline = coverage.outline();
  ASSERT_EQ(outline.size(), 1u);
  EXPECT_LE(outline[0].size(), 12u);
  EXPECT_NEAR(area_of(outline[0]), coverage.area(), tolerance(coverage, 43));
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
