// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/mosaic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "blending.hpp"
#include "nadir/core/check.hpp"

namespace nadir::mosaic2d {
namespace {

constexpr double kGsd = 0.01;

MosaicGrid grid() {
  MosaicGrid grid;
  grid.mosaic = 3;
  grid.ground_sampling_distance = kGsd;
  grid.world = {kGsd, 0, 0, -kGsd, 12.34, -56.78};
  return grid;
}

// An opaque image whose top left pixel is (column, row) of the raster.
ProjectedImage image_at(int column, int row, const cv::Mat& bgra) {
  ProjectedImage image;
  image.bgra = bgra;
  image.world = grid().world;
  image.world.c += column * kGsd;
  image.world.f -= row * kGsd;
  return image;
}

cv::Mat uniform(int width, int height, int grey) {
  return {height, width, CV_8UC4, cv::Scalar(grey, grey, grey, 255)};
}

cv::Vec4b pixel(const Mosaic& mosaic, int column, int row) {
  for (const auto& tile : mosaic.tiles()) {
    const cv::Point p(column - 256 * tile->column, row - 256 * tile->row);
    if (p.inside({0, 0, 256, 256})) return tile->bgra.at<cv::Vec4b>(p);
  }
  return {};
}

cv::Mat speckled(int width, int height, unsigned seed, double hole) {
  std::mt19937 random(seed);
  cv::Mat bgra(height, width, CV_8UC4);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      auto& p = bgra.at<cv::Vec4b>(row, column);
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(random() % 256);
      const double from_middle = std::hypot(column - width / 2.0, row - height / 2.0);
      p[3] = from_middle < hole ? 0 : 255;
      if (p[3] == 0) p = {};
    }
  }
  return bgra;
}

TEST(Mosaic, PastesAnImageOntoItsTilesAlsoWestAndNorthOfTheOrigin) {
  Mosaic mosaic(grid());
  const cv::Mat image = speckled(300, 40, 1, 0);
  const auto changed = mosaic.add(image_at(-280, -10, image));
  ASSERT_EQ(changed.size(), 6u);  // columns -2 to 0, rows -1 and 0
  EXPECT_EQ(changed.front()->row, -1);
  EXPECT_EQ(changed.front()->column, -2);
  EXPECT_EQ(changed.front()->mosaic, 3u);
  for (int row = 0; row < 40; row += 3) {
    for (int column = 0; column < 300; column += 7) {
      EXPECT_EQ(pixel(mosaic, column - 280, row - 10), image.at<cv::Vec4b>(row, column));
    }
  }
  EXPECT_EQ(pixel(mosaic, 20, 0), cv::Vec4b());
}

TEST(Mosaic, NeverWritesATileItGaveOut) {
  Mosaic mosaic(grid());
  const auto first = mosaic.add(image_at(0, 0, uniform(200, 200, 50)));
  ASSERT_EQ(first.size(), 1u);
  const cv::Mat before = first[0]->bgra.clone();
  const auto second = mosaic.add(image_at(80, 0, uniform(200, 200, 150)));
  EXPECT_EQ(cv::norm(before, first[0]->bgra, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(before, second[0]->bgra, cv::NORM_INF), 0);
}

TEST(Mosaic, ReportsOnlyTilesThatChanged) {
  Mosaic mosaic(grid());
  mosaic.add(image_at(0, 0, uniform(400, 100, 50)));
  EXPECT_TRUE(mosaic.add(image_at(0, 0, uniform(400, 100, 90))).empty());  // the same view again
  EXPECT_EQ(mosaic.add(image_at(300, 0, uniform(200, 100, 90))).size(), 1u);
  EXPECT_TRUE(mosaic.add(image_at(5000, 0, cv::Mat::zeros(50, 50, CV_8UC4))).empty());
  EXPECT_EQ(mosaic.tiles().size(), 2u);
}

TEST(Mosaic, ShowsTheImageWhoseCentreIsNearer) {
  Mosaic mosaic(grid());
  mosaic.add(image_at(0, 0, uniform(200, 120, 50)));
  mosaic.add(image_at(100, 0, uniform(200, 120, 150)));
  for (int row = 40; row < 80; row += 5) {
    EXPECT_EQ(pixel(mosaic, 130, row)[0], 50) << row;  // centres at 99.5 and 199.5
    EXPECT_EQ(pixel(mosaic, 168, row)[0], 150) << row;
  }
}

TEST(Mosaic, PassesSmoothlyFromImageToImage) {
  Mosaic mosaic(grid());
  mosaic.add(image_at(0, 0, uniform(200, 120, 50)));
  mosaic.add(image_at(100, 0, uniform(200, 120, 150)));
  for (int column = 100; column < 200; ++column) {
    const int step = pixel(mosaic, column + 1, 60)[0] - pixel(mosaic, column, 60)[0];
    EXPECT_GE(step, 0) << column;
    EXPECT_LE(step, 5) << column;  // 100 levels over 32 px, and rounding
  }
}

TEST(Mosaic, FeathersTheBorderOfAnImageInsideAnother) {
  Mosaic mosaic(grid());
  mosaic.add(image_at(0, 0, uniform(400, 400, 50)));
  mosaic.add(image_at(290, 140, uniform(80, 80, 150)));  // wins by centre, ends inside the other
  EXPECT_EQ(pixel(mosaic, 330, 180)[0], 150);
  for (int column = 280; column < 330; ++column) {
    EXPECT_LE(std::abs(pixel(mosaic, column + 1, 180)[0] - pixel(mosaic, column, 180)[0]), 9);
  }
}

TEST(Mosaic, IsRebuiltBitByBitFromItsProjectedImages) {
  std::vector<ProjectedImage> images;
  std::mt19937 random(5);
  for (unsigned i = 0; i < 12; ++i) {
    const auto at = [&] { return static_cast<int>(random() % 500) - 250; };
    const int column = at(), row = at();
    images.push_back(image_at(column, row, speckled(230, 170, i, 10)));
  }
  Mosaic live(grid()), rebuilt(grid());
  for (const ProjectedImage& image : images) live.add(image);
  for (ProjectedImage image : images) {
    image.bgra = image.bgra.clone();
    image.world.c = std::stod(std::to_string(image.world.c));  // as a world file rounds it
    rebuilt.add(image);
  }
  const auto a = live.tiles(), b = rebuilt.tiles();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i]->row, b[i]->row);
    EXPECT_EQ(a[i]->column, b[i]->column);
    EXPECT_EQ(cv::norm(a[i]->bgra, b[i]->bgra, cv::NORM_INF), 0);
  }
}

TEST(Mosaic, MatchesTheBrightnessOfWhatIsThere) {
  Mosaic mosaic(grid());
  EXPECT_EQ(mosaic.gain_to_match(image_at(0, 0, uniform(200, 200, 100))), cv::Vec3d(1, 1, 1));
  mosaic.add(image_at(0, 0, uniform(200, 200, 100)));
  const cv::Vec3d gain = mosaic.gain_to_match(image_at(50, 0, uniform(200, 200, 80)));
  EXPECT_NEAR(gain[0], 1.25, 0.01);
  EXPECT_EQ(mosaic.gain_to_match(image_at(195, 0, uniform(200, 200, 80)))[0], 1);  // too little
  EXPECT_LT(mosaic.gain_to_match(image_at(0, 0, uniform(200, 200, 1)))[0], 2);
}

TEST(Mosaic, RefusesAnImageOfAnotherRaster) {
  Mosaic mosaic(grid());
  ProjectedImage shifted = image_at(0, 0, uniform(10, 10, 1));
  shifted.world.c += 0.3 * kGsd;
  EXPECT_THROW(mosaic.add(shifted), ContractError);
  ProjectedImage coarser = image_at(0, 0, uniform(10, 10, 1));
  coarser.world.a *= 2;
  EXPECT_THROW(mosaic.add(coarser), ContractError);
}

// What blend_patch does, pixel by pixel: the newer image's share by the distances alone.
void blend_by_definition(const Patch& from, Ground& onto, cv::Point origin,
                         const std::vector<cv::Point2d>& centres) {
  constexpr double kFeather = 16;
  for (int row = 0; row < from.bgra.rows; ++row) {
    for (int column = 0; column < from.bgra.cols; ++column) {
      const auto image = from.bgra.at<cv::Vec4b>(row, column);
      auto& ground = onto.bgra.at<cv::Vec4b>(row, column);
      auto& owner = onto.owner.at<std::uint16_t>(row, column);
      auto& border = onto.border.at<std::uint8_t>(row, column);
      const int own_border = from.border.at<std::uint8_t>(row, column);
      if (image[3] == 0) continue;
      double share = 1;
      if (ground[3] != 0) {
        const cv::Point2d older = centres[owner];
        const cv::Point2d step = centres.back() - older;
        const double length = std::hypot(step.x, step.y);
        const cv::Point2d at = cv::Point2d(origin + cv::Point(column, row));
        double x =
            length < 1 ? -kFeather : (at - (older + centres.back()) * 0.5).dot(step) / length;
        x = std::max(x, own_border - border - kFeather);
        x = std::min(x, own_border - kFeather);
        share = (std::clamp(x, -kFeather, kFeather) + kFeather) / (2 * kFeather);
      }
      border = std::max(border, static_cast<std::uint8_t>(own_border));
      for (int c = 0; c < 3; ++c) {
        ground[c] = cv::saturate_cast<std::uint8_t>((1 - share) * ground[c] + share * image[c]);
      }
      ground[3] = 255;
      if (share > 0.5) owner = static_cast<std::uint16_t>(centres.size() - 1);
    }
  }
}

// Owners that change from column to column, bare ground, holes, rows of any length and place. A
// share is cut to 1/256, and the seam where it is one half may lie a pixel off.
TEST(Blending, IsWhatEachPixelsDistancesSay) {
  std::mt19937 random(11);
  for (const int width : {1, 7, 8, 15, 16, 17, 33, 100}) {
    const cv::Size size(width, 40);
    const std::vector<cv::Point2d> centres{{10.3, 5.2}, {60.1, 30.7}, {35, 80}, {20.6, 22.4}};
    const cv::Mat whole = speckled(width + 9, 50, 3, 6);
    Patch from{whole(cv::Rect({5, 4}, size)), outline(whole).border(cv::Rect({5, 4}, size))};
    Ground fast{speckled(width, 40, 4, 4), cv::Mat(size, CV_16UC1), cv::Mat(size, CV_8UC1)};
    for (auto& owner : cv::Mat_<std::uint16_t>(fast.owner))
      owner = static_cast<std::uint16_t>(random() % 3);
    fast.owner.colRange(width / 2, width) = cv::Scalar(1);
    for (auto& border : cv::Mat_<std::uint8_t>(fast.border)) {
      border = static_cast<std::uint8_t>(random() % 33);
    }
    Ground slow{fast.bgra.clone(), fast.owner.clone(), fast.border.clone()};
    blend_patch(from, fast, {12, 9}, centres);
    blend_by_definition(from, slow, {12, 9}, centres);
    EXPECT_LE(cv::norm(fast.bgra, slow.bgra, cv::NORM_INF), 2) << width;
    EXPECT_EQ(cv::norm(fast.border, slow.border, cv::NORM_INF), 0) << width;
    EXPECT_LE(cv::countNonZero(fast.owner != slow.owner), width * 40 / 50 + 1) << width;
  }
}

TEST(Outline, MeasuresTheCityBlockDistanceToTheBorder) {
  cv::Mat image = uniform(90, 80, 10);
  image.at<cv::Vec4b>(40, 45) = {};
  const Outline seen = outline(image);
  ASSERT_TRUE(seen.centre);
  EXPECT_NEAR(seen.centre->x, 44.5, 0.01);
  EXPECT_NEAR(seen.centre->y, 39.5, 0.01);
  for (int row = 0; row < 80; ++row) {
    for (int column = 0; column < 90; ++column) {
      const int hole = std::abs(row - 40) + std::abs(column - 45);
      const int expected = std::min({32, hole, row + 1, column + 1, 80 - row, 90 - column});
      ASSERT_EQ(seen.border.at<std::uint8_t>(row, column), expected) << column << ' ' << row;
    }
  }
  EXPECT_FALSE(outline(cv::Mat::zeros(5, 5, CV_8UC4)).centre);
}

}  // namespace
}  // namespace nadir::mosaic2d
