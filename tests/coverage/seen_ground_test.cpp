// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/seen_ground.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nadir::coverage {
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

/// Of ground whose border is so long: a cell more or less along it.
double tolerance(const SeenGround& ground, double border) { return border * ground.cell(); }

TEST(SeenGround, IsTheUnionOfTheFootprints) {
  SeenGround ground;
  EXPECT_EQ(ground.area(), 0);
  EXPECT_TRUE(ground.outline().empty());
  ground.add(box(-3, 2, 1, 0.8));
  EXPECT_NEAR(ground.area(), 0.8, tolerance(ground, 3.6));
  ground.add(box(-2.5, 2, 1, 0.8));  // half of it is new
  EXPECT_NEAR(ground.area(), 1.2, tolerance(ground, 4.6));
  ground.add(box(7, -9, 1, 0.8));  // far away, before the origin in y
  EXPECT_NEAR(ground.area(), 2.0, tolerance(ground, 8.2));
}

TEST(SeenGround, OutlinesEachPatchWhereItLies) {
  SeenGround ground;
  ground.add(box(-3, 2, 1, 0.8));
  ground.add(box(7, -9, 2, 1));
  const auto outline = ground.outline();
  ASSERT_EQ(outline.size(), 2u);
  for (const Polygon& polygon : outline) {
    const bool first = polygon[0].x() < 0;
    EXPECT_NEAR(area_of(polygon), first ? 0.8 : 2, tolerance(ground, first ? 3.6 : 6));
    EXPECT_LE(polygon.size(), 8u);
    const double cell = 1.001 * ground.cell();
    for (const Vector2d& corner : polygon) {
      EXPECT_GT(corner.x(), (first ? -3 : 7) - cell);
      EXPECT_LT(corner.x(), (first ? -2 : 9) + cell);
      EXPECT_GT(corner.y(), (first ? 2 : -9) - cell);
      EXPECT_LT(corner.y(), (first ? 2.8 : -8) + cell);
    }
  }
}

TEST(SeenGround, OutlinesAHoleThatWasLeftOut) {
  SeenGround ground;
  for (const Polygon& side : {box(0, 0, 3, 1), box(0, 2, 3, 1), box(0, 0, 1, 3), box(2, 0, 1, 3)})
    ground.add(side);
  const auto outline = ground.outline();
  ASSERT_EQ(outline.size(), 2u);
  const double inner = std::min(area_of(outline[0]), area_of(outline[1]));
  EXPECT_NEAR(inner, 1, tolerance(ground, 4));
  EXPECT_NEAR(ground.area(), 8, tolerance(ground, 16));
}

TEST(SeenGround, StaysSmallOverALongWay) {
  SeenGround ground;
  constexpr int kImages = 5000;  // 2.5 km
  for (int i = 0; i < kImages; ++i) ground.add(box(0.5 * i, 0.1 * i, 1, 0.8));
  EXPECT_GT(ground.cell(), 1.0 / 32);
  const double length = std::hypot(0.5, 0.1) * kImages;
  EXPECT_NEAR(ground.area(), 0.5 * kImages * 0.8, 2.2 * tolerance(ground, 2 * length));
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

TEST(SeenGround, TakesLittleMemoryOverALargeSurvey) {
  const CountingAllocator memory;
  SeenGround ground;
  constexpr double kLength = 500, kApart = 2.5, kWide = 1, kHigh = 0.8;
  constexpr int kLegs = 160;
  for (int leg = 0; leg < kLegs; ++leg) {
    for (double along = 0; along + kHigh <= kLength; along += kHigh / 2)
      ground.add(box(kApart * leg, leg % 2 == 0 ? along : kLength - kHigh - along, kWide, kHigh));
  }
  EXPECT_LT(ground.cell(), kWide / 4);  // the ground between the legs is told apart
  const double border = kLegs * 2 * (kLength + kWide);
  EXPECT_NEAR(ground.area(), kLegs * kWide * kLength, tolerance(ground, border));
  const auto outline = ground.outline();
  EXPECT_EQ(outline.size(), static_cast<std::size_t>(kLegs));
  for (const Polygon& leg : outline)
    EXPECT_NEAR(area_of(leg), kWide * kLength, tolerance(ground, 2 * (kLength + kWide)));
  EXPECT_LT(memory.most(), 16'000'000u);
}

TEST(SeenGround, TakesLittleMemoryWhateverComes) {
  const CountingAllocator memory;
  SeenGround ground;
  for (const double far : {1.0, 30.0, 79.0, 200.0, 1e3, 1e6, 1e9}) {
    for (const Vector2d& at : {Vector2d(far, 0), {-far, far}, {0, -far}})
      ground.add(box(at.x(), at.y(), 1, 1));
    ground.add(box(-far, -far, far, far));
    EXPECT_FALSE(ground.outline().empty());
  }
  EXPECT_LT(memory.most(), 16'000'000u);
}

TEST(SeenGround, KeepsAllGroundWhenItIsMadeCoarser) {
  SeenGround ground;
  for (int i = 0; i < 100; ++i) ground.add(box(2 * (i % 10), 2 * (i / 10), 1, 1));
  EXPECT_EQ(ground.outline().size(), 100u);
  double area = ground.area();
  for (int i = 0; i < 20; ++i) {
    ground.coarsen();
    EXPECT_GE(ground.area(), area);
    area = ground.area();
    double outlined = 0;
    for (const Polygon& polygon : ground.outline()) outlined += area_of(polygon);
    EXPECT_GE(outlined, 100) << i;
  }
  ASSERT_EQ(ground.outline().size(), 1u);
  EXPECT_EQ(ground.outline()[0].size(), 4u);
}

TEST(SeenGround, OutlinesASlantingWayByItsCorners) {
  SeenGround ground;
  const Vector2d along = Vector2d(1, 0.2).normalized(), across(-along.y(), along.x());
  for (double s = 0; s < 20; s += 0.25) {
    Polygon footprint;
    for (const Vector2d& corner : box(s, 0, 1, 0.8))
      footprint.push_back(corner.x() * along + corner.y() * across);
    ground.add(footprint);
  }
  const auto outline = ground.outline();
  ASSERT_EQ(outline.size(), 1u);
  EXPECT_LE(outline[0].size(), 12u);
  EXPECT_NEAR(area_of(outline[0]), ground.area(), tolerance(ground, 43));
}

TEST(SeenGround, LeavesOutFootprintsThatAreNone) {
  SeenGround ground;
  ground.add(Polygon{{0, 0}, {1, 1}});
  ground.add(Polygon{{0, 0}, {1, NAN}, {1, 1}});
  ground.add(Polygon{{0, 0}, {1, 0}, {2, 0}});
  EXPECT_EQ(ground.area(), 0);
}

}  // namespace
}  // namespace nadir::coverage
