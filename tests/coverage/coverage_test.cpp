// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/coverage.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "ground.hpp"

namespace nadir::coverage {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 1.6, kLength = 1.2, kCell = 0.02;

/// Swims strips along a heading, an image every 0.4 m.
class Swimmer {
 public:
  explicit Swimmer(Coverage& coverage, double heading = 0)
      : coverage_(coverage), heading_(heading) {}

  void strip(double aside, double from, double to) {
    for (double along = from; along <= to + 1e-9; along += 0.4) {
      const Vector2d at = place(aside, along);
      coverage_.add(footprint_at(image_++, at.x(), at.y(), kWidth, kLength, heading_));
    }
  }
  Vector2d place(double aside, double along) const {
    return {aside * std::cos(heading_) + along * std::sin(heading_),
            along * std::cos(heading_) - aside * std::sin(heading_)};
  }

 private:
  Coverage& coverage_;
  double heading_;
  std::uint64_t image_ = 0;
};

int pixel_at(const Coverage& coverage, const Vector2d& at) {
  const int column = static_cast<int>(std::floor(at.x() / coverage.cell()));
  const int row = static_cast<int>(std::floor(-at.y() / coverage.cell()));
  const auto tile = [](int cell) {
    return static_cast<int>(std::floor(cell / double{Counts::kTileSide}));
  };
  const Place place{tile(column), tile(row)};
  const int x = column - Counts::kTileSide * place.column;
  const int y = row - Counts::kTileSide * place.row;
  return coverage.pixels(place)[static_cast<std::size_t>(Counts::kTileSide * y + x)];
}

TEST(Coverage, OfOneImageIsItsFootprint) {
  for (const double heading : {0.0, 0.3, 0.8}) {
    Coverage coverage;
    EXPECT_TRUE(coverage.update().empty());
    EXPECT_EQ(coverage.area(), 0);
    Swimmer(coverage, heading).strip(0, 0, 0);
    EXPECT_FALSE(coverage.update().empty());
    EXPECT_DOUBLE_EQ(coverage.cell(), kCell);
    EXPECT_NEAR(coverage.area(), kWidth * kLength, kCell * 3);
    EXPECT_EQ(coverage.covered(), coverage.area()) << heading;
    EXPECT_EQ(coverage.seen(), coverage.covered());
    EXPECT_TRUE(coverage.gaps({0, 0}, 10).empty());
    EXPECT_EQ(pixel_at(coverage, {0.01, 0.01}), 129);
    EXPECT_EQ(pixel_at(coverage, {5, 5}), 0);
  }
}

// Lanes 1.12 m apart (0.7 footprints) leave no gap; one left out leaves 0.64 m.
constexpr double kSpacing = 0.7 * kWidth, kLaneLength = 12;
constexpr double kLeftOut = 2 * kSpacing - kWidth;

void swim_lanes(Swimmer& swimmer, int lanes, const std::set<int>& left_out) {
  for (int lane = 0; lane < lanes; ++lane) {
    if (!left_out.contains(lane)) swimmer.strip(kSpacing * lane, 0, kLaneLength);
  }
}

TEST(Coverage, OfLanesHasNoGapWhenNoneIsLeftOut) {
  for (const double heading : {0.0, 0.5}) {
    Coverage coverage;
    Swimmer swimmer(coverage, heading);
    swim_lanes(swimmer, 6, {});
    coverage.update();
    EXPECT_TRUE(coverage.gaps({0, 0}, 10).empty());
    EXPECT_GT(coverage.covered() / coverage.area(), 0.999);
  }
}

TEST(Coverage, OfLanesHasOneGapForTheOneLeftOut) {
  for (const double heading : {0.0, 0.5, 1.2}) {
    Coverage coverage;
    Swimmer swimmer(coverage, heading);
    swim_lanes(swimmer, 6, {3});
    coverage.update();
    const std::vector<Gap> gaps = coverage.gaps({0, 0}, 10);
    ASSERT_EQ(gaps.size(), 1u) << heading;
    // The open ends are a few cells shorter than the lanes.
    const double length = kLaneLength + kLength;
    EXPECT_NEAR(gaps[0].area, kLeftOut * length, kLeftOut * 8 * kCell + 2 * kCell * length)
        << heading;
    const Vector2d middle = swimmer.place(3 * kSpacing, kLaneLength / 2);
    EXPECT_LT((gaps[0].centre - middle).norm(), 1.5);
    EXPECT_EQ(pixel_at(coverage, gaps[0].centre), 128);
    EXPECT_NEAR(coverage.area() - coverage.covered(), gaps[0].area, 0.1);
  }
}

TEST(Coverage, TellsTheNearestGapFirst) {
  Coverage coverage;
  Swimmer swimmer(coverage);
  swim_lanes(swimmer, 12, {2, 6, 9});
  coverage.update();
  for (const auto& [from, lane] : {std::pair(0.0, 2),
                                   {3.9 * kSpacing, 2},
                                   {4.1 * kSpacing, 6},
                                   {7.4 * kSpacing, 6},
                                   {7.6 * kSpacing, 9},
                                   {99.0, 9}}) {
    const std::vector<Gap> gaps = coverage.gaps(swimmer.place(from, kLaneLength / 2), 2);
    ASSERT_EQ(gaps.size(), 2u);
    EXPECT_NEAR(gaps[0].centre.x(), lane * kSpacing, kLeftOut / 2) << from;
  }
  EXPECT_EQ(coverage.gaps({0, 0}, 255).size(), 3u);
}

TEST(Coverage, LeavesTheOpenOutsideOut) {
  // Two strips farther apart than 1.5 footprints, a bend, and a straight line.
  Coverage apart;
  Swimmer(apart).strip(0, 0, 8);
  Swimmer(apart).strip(0, 0, 0);
  Swimmer swimmer(apart);
  swimmer.strip(kWidth + 1.6 * kWidth, 0, 8);
  swimmer.strip(0, 10, 18);
  apart.update();
  EXPECT_TRUE(apart.gaps({0, 0}, 10).empty());

  Coverage bend;
  std::uint64_t image = 0;
  for (double way = 0; way < 6; way += 0.3) bend.add(footprint_at(image++, 0, way));
  for (double way = 0; way < 6; way += 0.3) bend.add(footprint_at(image++, way, 6));
  bend.update();
  EXPECT_TRUE(bend.gaps({0, 0}, 10).empty());
  EXPECT_GT(bend.covered() / bend.area(), 0.995);
}

TEST(Coverage, CountsAHoleOfAnySizeAsAGap) {
  Coverage coverage;
  std::uint64_t image = 0;
  constexpr double kHalf = 9;
  for (double way = -kHalf; way < kHalf; way += 0.5) {
    for (const Vector2d& at : {Vector2d(way, -kHalf), {kHalf, way}, {-way, kHalf}, {-kHalf, -way}})
      coverage.add(footprint_at(image++, at.x(), at.y()));
  }
  coverage.update();
  const std::vector<Gap> gaps = coverage.gaps({20, 20}, 10);
  ASSERT_EQ(gaps.size(), 1u);
  const double inner = (2 * kHalf - kWidth) * (2 * kHalf - kLength);
  EXPECT_NEAR(gaps[0].area, inner, 4 * 2 * kHalf * kCell);
  EXPECT_LT(gaps[0].centre.norm(), 1);
  EXPECT_EQ(pixel_at(coverage, {0.01, 0.01}), 128);
  // Where nobody ever was there are tiles, too.
  EXPECT_NEAR(coverage.area(), (2 * kHalf + kWidth) * (2 * kHalf + kLength), 2 * 2 * kHalf * kCell);
}

TEST(Coverage, OfAPlanCountsWithinItOnly) {
  Coverage coverage;
  const Polygon plan{{0, 0}, {10, 0}, {10, 5}, {0, 5}};
  coverage.aim(plan);
  EXPECT_DOUBLE_EQ(coverage.area(), 50);
  Swimmer(coverage).strip(0, 0, 4.8);  // the left half of it lies outside
  coverage.update();
  EXPECT_DOUBLE_EQ(coverage.area(), 50);
  EXPECT_NEAR(coverage.covered(), 5 * kWidth / 2, kCell * 6);
  EXPECT_NEAR(coverage.seen(), kWidth * (4.8 + kLength), kCell * 14);
  std::vector<Gap> gaps = coverage.gaps({0, 0}, 10);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_NEAR(gaps[0].area, 50 - coverage.covered(), 0.1);
  EXPECT_NEAR(coverage.covered(Polygon{{0, 0}, {1.6, 0}, {1.6, 5}, {0, 5}}), 0.5, 0.02);
  EXPECT_EQ(pixel_at(coverage, {-0.4, 2}) & 128, 0);
  EXPECT_EQ(pixel_at(coverage, {9.9, 4.9}), 128);

  coverage.aim(Polygon{{0, 0}, {0.7, 0}, {0.7, 5}, {0, 5}});
  coverage.update();
  EXPECT_TRUE(coverage.gaps({0, 0}, 10).empty());
  EXPECT_NEAR(coverage.covered(), 3.5, 0.1);
  coverage.aim({});
  coverage.update();
  EXPECT_NEAR(coverage.area(), coverage.seen(), 1e-9);
}

// Whatever the order and the steps in which it is told, the ground is the same.
TEST(Coverage, KeptUpToDateIsThatOfAFreshOne) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-7, 7), heading(0, std::numbers::pi), shift(-1, 1);
  Coverage kept(0.05);
  std::vector<Footprint> footprints;
  std::map<Place, Coverage::Pixels> told;
  const auto update = [&] {
    for (const Place& at : kept.update()) told[at] = kept.pixels(at);
  };
  for (std::uint64_t image = 0; image < 90; ++image) {
    footprints.push_back(
        footprint_at(image, place(random), place(random), kWidth, kLength, heading(random)));
    kept.add(footprints.back());
    if (image % 3 == 0) update();
    if (image % 20 != 19) continue;
    kept.correct({{image - 15,
                   0,
                   {1, {Eigen::Quaterniond::Identity(), {shift(random), shift(random), 0}}}}});
    update();
  }
  update();
  Coverage fresh(0.05);
  for (Footprint footprint : footprints) {
    const Similarity3 correction = kept.corrections().at(0, footprint.image);
    for (Eigen::Vector3d& corner : footprint.corners) corner = correction * corner;
    fresh.add(footprint);
  }
  for (const Place& at : fresh.update()) EXPECT_EQ(kept.pixels(at), fresh.pixels(at));
  for (const auto& [at, pixels] : told) EXPECT_EQ(pixels, fresh.pixels(at));
  EXPECT_DOUBLE_EQ(kept.area(), fresh.area());
  EXPECT_DOUBLE_EQ(kept.covered(), fresh.covered());
  EXPECT_LT(fresh.covered(), fresh.area());
  EXPECT_EQ(kept.gaps({0, 0}, 99).size(), fresh.gaps({0, 0}, 99).size());
}

TEST(Coverage, BearsALongWay) {
  Coverage coverage;
  std::uint64_t image = 0;
  double updated = 0;
  for (double way = 0; way < 3000; way += 0.6) {
    coverage.add(footprint_at(image++, 0.7 * way, 0.7 * way));
    if (way - updated < 100) continue;
    updated = way;
    coverage.update();
    EXPECT_TRUE(coverage.gaps({0, 0}, 10).empty()) << way;
  }
  EXPECT_GT(coverage.seen(), 3000 * 1.2);
}

}  // namespace
}  // namespace nadir::coverage
