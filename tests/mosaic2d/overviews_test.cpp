// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/overviews.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace nadir::mosaic2d {
namespace {

constexpr int kSize = MosaicGrid::kTileSize;
constexpr int kSide = kSize / Overviews::kTiles;
constexpr std::size_t kAll = 1000;

Tile tile(std::int32_t column, std::int32_t row, const cv::Scalar& bgra, std::uint32_t mosaic = 0) {
  return {mosaic, column, row, cv::Mat(kSize, kSize, CV_8UC4, bgra)};
}

cv::Vec4b centre(const Tile& overview, int column, int row) {
  return overview.bgra.at<cv::Vec4b>(kSide * row + kSide / 2, kSide * column + kSide / 2);
}

TEST(Overviews, ShowEachTileInItsPlace) {
  Overviews overviews;
  for (int column = 0; column < Overviews::kTiles; ++column) {
    for (int row = 0; row < Overviews::kTiles; ++row) {
      overviews.add(tile(column, row, {10.0 * column, 10.0 * row, 99, 255}));
    }
  }
  const std::vector<Tile> taken = overviews.take(kAll);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].bgra.size(), cv::Size(kSize, kSize));
  for (int column = 0; column < Overviews::kTiles; ++column) {
    for (int row = 0; row < Overviews::kTiles; ++row) {
      const cv::Vec4i shown = centre(taken[0], column, row);
      EXPECT_EQ(shown, cv::Vec4i(10 * column, 10 * row, 99, 255));
    }
  }
}

TEST(Overviews, GoOnBeyondTheMosaicsOrigin) {
  Overviews overviews;
  overviews.add(tile(-1, 7, {1, 1, 1, 255}));
  overviews.add(tile(-8, -9, {2, 2, 2, 255}));
  overviews.add(tile(8, 0, {3, 3, 3, 255}));
  const std::vector<Tile> taken = overviews.take(kAll);  // row by row
  ASSERT_EQ(taken.size(), 3u);
  EXPECT_EQ(std::pair(taken[0].column, taken[0].row), std::pair(-1, -2));
  EXPECT_EQ(centre(taken[0], 0, 7)[0], 2);
  EXPECT_EQ(std::pair(taken[1].column, taken[1].row), std::pair(-1, 0));
  EXPECT_EQ(centre(taken[1], 7, 7)[0], 1);
  EXPECT_EQ(std::pair(taken[2].column, taken[2].row), std::pair(1, 0));
  EXPECT_EQ(centre(taken[2], 0, 0)[0], 3);
}

TEST(Overviews, KeepMosaicsApart) {
  Overviews overviews;
  overviews.add(tile(0, 0, {1, 1, 1, 255}, 0));
  overviews.add(tile(0, 0, {2, 2, 2, 255}, 1));
  const std::vector<Tile> taken = overviews.take(kAll);
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken[1].mosaic, 1u);
  EXPECT_EQ(centre(taken[1], 0, 0)[0], 2);
}

TEST(Overviews, GiveTheMeanOfWhatWasSeenAndHowMuchThatWas) {
  Tile half = tile(0, 0, {40, 80, 120, 255});
  for (int column = 0; column < kSize; ++column) {
    if (column % 4 < 2) continue;
    half.bgra.col(column) =
        column % 4 == 2 ? cv::Scalar(60, 100, 140, 255) : cv::Scalar(255, 0, 0, 0);
  }
  Overviews overviews;
  overviews.add(half);
  const cv::Vec4b pixel = centre(overviews.take(kAll).at(0), 0, 0);
  // Two of four columns of 40 and one of 60, one unseen.
  EXPECT_NEAR(pixel[0], (2 * 40 + 60) / 3.0, 0.51);
  EXPECT_NEAR(pixel[1], (2 * 80 + 100) / 3.0, 0.51);
  EXPECT_NEAR(pixel[2], (2 * 120 + 140) / 3.0, 0.51);
  EXPECT_NEAR(pixel[3], 0.75 * 255, 0.51);
}

TEST(Overviews, AreTakenOnceForEachChange) {
  Overviews overviews;
  for (int column = 0; column < 5; ++column) {
    overviews.add(tile(Overviews::kTiles * column, 0, {1, 1, 1, 255}));
  }
  EXPECT_EQ(overviews.take(3).size(), 3u);
  EXPECT_EQ(overviews.take(3).size(), 2u);
  EXPECT_TRUE(overviews.take(3).empty());
  overviews.add(tile(Overviews::kTiles + 1, 1, {7, 7, 7, 255}));
  const std::vector<Tile> taken = overviews.take(3);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(centre(taken[0], 1, 1)[0], 7);
  EXPECT_EQ(centre(taken[0], 0, 0)[0], 1) << "what it showed before is still there";
}

}  // namespace
}  // namespace nadir::mosaic2d
