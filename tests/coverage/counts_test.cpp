// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/counts.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "ground.hpp"

namespace nadir::coverage {
namespace {

constexpr int kSide = Counts::kTileSide;

int count_at(const Counts& counts, double x, double y) {
  const int column = static_cast<int>(std::floor(x / counts.cell()));
  const int row = static_cast<int>(std::floor(-y / counts.cell()));
  const Place place{static_cast<int>(std::floor(column / double{kSide})),
                    static_cast<int>(std::floor(row / double{kSide}))};
  const Counts::Cells* cells = counts.at(place);
  if (!cells) return 0;
  return (*cells)[static_cast<std::size_t>(kSide * (row - kSide * place.row) + column -
                                           kSide * place.column)];
}

int cells_seen(const Counts& counts) {
  int seen = 0;
  for (const Place& place : counts.places()) {
    for (const std::uint8_t count : *counts.at(place)) seen += count > 0 ? 1 : 0;
  }
  return seen;
}

TEST(Counts, ChooseCellsThatPeopleCanRead) {
  for (const auto& [shorter, cell] :
       {std::pair(1.2, 0.02), {1.7, 0.05}, {1.6, 0.05}, {3.1, 0.05}, {3.3, 0.1}, {0.4, 0.01}}) {
    Counts counts;
    counts.add(footprint_at(0, 0, 0, 2 * shorter, shorter));
    EXPECT_DOUBLE_EQ(counts.cell(), cell) << shorter;
    counts.add(footprint_at(1, 0, 0, 20 * shorter, 10 * shorter));
    EXPECT_DOUBLE_EQ(counts.cell(), cell);
  }
}

TEST(Counts, AnImageCountsOnceInEachCellItShows) {
  Counts counts;
  counts.add(footprint_at(0, 0, 0));
  counts.add(footprint_at(1, 0.8, 0));
  counts.recount();
  EXPECT_DOUBLE_EQ(counts.cell(), 0.02);
  EXPECT_EQ(count_at(counts, -0.79, 0.59), 1);
  EXPECT_EQ(count_at(counts, -0.81, 0.59), 0);
  EXPECT_EQ(count_at(counts, -0.79, 0.61), 0);
  EXPECT_EQ(count_at(counts, 0.01, -0.59), 2);
  EXPECT_EQ(count_at(counts, -0.01, -0.59), 1);
  EXPECT_EQ(count_at(counts, 1.59, 0), 1);
  EXPECT_EQ(cells_seen(counts), 120 * 60);
  counts.add(footprint_at(1, 0.8, 0));  // again
  EXPECT_TRUE(counts.recount().empty());
}

TEST(Counts, NeighboursThatShareABorderShareNoCell) {
  Counts counts;
  std::uint64_t image = 0;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      // Turned, so that borders run through cells.
      const double along = 1.2 * i, aside = 1.6 * j, heading = 0.3;
      counts.add(footprint_at(image++, aside * std::cos(heading) + along * std::sin(heading),
                              along * std::cos(heading) - aside * std::sin(heading), 1.6, 1.2,
                              heading));
    }
  }
  counts.recount();
  int most = 0;
  for (const Place& place : counts.places()) {
    for (const std::uint8_t count : *counts.at(place)) most = std::max<int>(most, count);
  }
  EXPECT_EQ(most, 1);
  EXPECT_NEAR(cells_seen(counts) * 0.02 * 0.02, 25 * 1.6 * 1.2, 0.02 * 14);
}

TEST(Counts, TellTheTilesThatChanged) {
  Counts counts;
  counts.add(footprint_at(0, 0.64, -0.64, 0.4, 0.4));  // the middle of tile (0, 0)
  EXPECT_DOUBLE_EQ(counts.cell(), 0.01);
  EXPECT_EQ(counts.recount(), (std::vector<Place>{{0, 0}, {0, 1}, {1, 0}, {1, 1}}));
  EXPECT_TRUE(counts.recount().empty());
  counts.add(footprint_at(1, -0.32, 0.32, 0.2, 0.2));
  EXPECT_EQ(counts.recount(), (std::vector<Place>{{-1, -1}}));
}

TEST(Counts, EndAt127) {
  Counts counts;
  for (std::uint64_t image = 0; image < 300; ++image) counts.add(footprint_at(image, 0, 0));
  counts.recount();
  EXPECT_EQ(count_at(counts, 0, 0), Counts::kMost);
  // Those that move away still count where they went.
  counts.correct({{1, 0, {1, {Eigen::Quaterniond::Identity(), {10, 0, 0}}}}});
  counts.recount();
  EXPECT_EQ(count_at(counts, 10, 0), Counts::kMost);
}

Similarity3 random_move(std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-3, 3), turn(-0.4, 0.4), size(0.8, 1.25);
  const Eigen::Vector3d axis(0.2 * turn(random), 0.2 * turn(random), 1);
  return {size(random),
          {Eigen::Quaterniond(Eigen::AngleAxisd(turn(random), axis.normalized())),
           {shift(random), shift(random), shift(random)}}};
}

// As if all were known from the beginning.
void expect_fresh_counts(const Counts& counts, const std::vector<Footprint>& footprints) {
  Counts fresh(counts.cell());
  for (Footprint footprint : footprints) {
    const Similarity3 correction = counts.corrections().at(footprint.submap, footprint.image);
    for (Eigen::Vector3d& corner : footprint.corners) corner = correction * corner;
    fresh.add(footprint);
  }
  fresh.recount();
  ASSERT_EQ(counts.places(), fresh.places());
  for (const Place& place : counts.places()) EXPECT_EQ(*counts.at(place), *fresh.at(place));
}

TEST(Counts, AfterAnyCorrectionsAreThoseOfAFreshCount) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-6, 6), heading(0, 2 * std::numbers::pi);
    std::uniform_int_distribution<std::uint64_t> any(0, 79);
    Counts counts;
    std::vector<Footprint> footprints;
    const auto told = [&] {
      std::map<Place, Counts::Cells> before;
      for (const Place& at : counts.places()) before[at] = *counts.at(at);
      const std::vector<Place> changed = counts.recount();
      const std::set<Place> listed(changed.begin(), changed.end());
      for (const Place& at : counts.places()) {
        const auto known = before.find(at);
        const Counts::Cells then = known == before.end() ? Counts::Cells{} : known->second;
        EXPECT_EQ(listed.contains(at), then != *counts.at(at));
      }
    };
    for (std::uint64_t image = 0; image < 80; ++image) {
      footprints.push_back(footprint_at(image, place(random), place(random), 1.6, 1.2,
                                        heading(random), image < 50 ? 0 : 1));
      counts.add(footprints.back());
      if (image % 9 == 0) told();
      if (image % 13 != 0) continue;
      std::vector<Correction> corrections;
      for (int i = 0; i < 3; ++i) {
        const std::uint64_t key_frame = any(random);
        corrections.push_back({key_frame, key_frame < 50 ? 0u : 1u, random_move(random)});
      }
      counts.correct(corrections);
      told();
    }
    told();
    expect_fresh_counts(counts, footprints);
  }
}

TEST(Counts, LeaveOutWhatNoImageShows) {
  Counts counts;
  counts.add(footprint_at(0, 0, 0));
  counts.recount();
  const int seen = cells_seen(counts);
  counts.add(footprint_at(1, 1e9, 0));
  counts.add(footprint_at(2, NAN, 0));
  counts.add(footprint_at(3, 0, 0, 1e4, 1e4));
  EXPECT_TRUE(counts.recount().empty());
  EXPECT_EQ(cells_seen(counts), seen);
  Counts none;
  none.add(footprint_at(0, 0, 0, 0, 0));
  EXPECT_EQ(none.cell(), 0);
  EXPECT_TRUE(none.recount().empty());
}

}  // namespace
}  // namespace nadir::coverage
