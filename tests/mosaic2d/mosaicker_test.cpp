// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/mosaicker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mosaic2d/scene.hpp"
#include "nadir/core/check.hpp"

namespace nadir::mosaic2d {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using test::Scene;

class MosaickerTest : public testing::Test {
 protected:
  MosaicUpdate see(const Scene& scene) {
    return mosaicker_.process(test::surface_of(scene, test::grey_image(scene.camera)));
  }
  static Scene sloping(double slope_deg) {
    Scene scene;
    const double slope = slope_deg * std::numbers::pi / 180;
    scene.plane = test::plane_through({0, 0, 0}, {std::sin(slope), 0, std::cos(slope)});
    return scene;
  }

  Mosaicker mosaicker_{Config{}};
};

TEST_F(MosaickerTest, SnapsEveryProjectedImageToTheMosaicsRaster) {
  Scene scene;
  for (int i = 0; i < 5; ++i) {
    scene.survey_from_camera = test::camera_at({0.123 * i, 0.0777 * i, 2}, 10 * i, i);
    scene.image = static_cast<std::uint64_t>(i + 40);
    const MosaicUpdate update = see(scene);
    ASSERT_TRUE(update.grid && update.projected);
    const WorldFile &world = update.projected->world, &grid = update.grid->world;
    const double gsd = update.grid->ground_sampling_distance;
    EXPECT_DOUBLE_EQ(gsd, 0.0044);  // 2 / 459 = 0.00436
    EXPECT_EQ(update.grid->mosaic, 0u);
    EXPECT_EQ(update.projected->image, scene.image);
    EXPECT_NEAR(std::remainder(world.c - grid.c, gsd), 0, 1e-9);
    EXPECT_NEAR(std::remainder(world.f - grid.f, gsd), 0, 1e-9);
    EXPECT_FALSE(update.tiles.empty());
    EXPECT_TRUE(update.alerts.empty());
  }
}

TEST_F(MosaickerTest, TilesShowTheProjectedImage) {
  const MosaicUpdate update = see(Scene{});
  const WorldFile &world = update.projected->world, &grid = update.grid->world;
  const double gsd = update.grid->ground_sampling_distance;
  const int left = static_cast<int>(std::lround((world.c - grid.c) / gsd));
  const int top = static_cast<int>(std::lround((grid.f - world.f) / gsd));
  int seen = 0;
  for (const auto& tile : update.tiles) {
    for (int row = 0; row < 256; ++row) {
      for (int column = 0; column < 256; ++column) {
        if (tile->bgra.at<cv::Vec4b>(row, column)[3] == 0) continue;
        const cv::Point p(256 * tile->column + column - left, 256 * tile->row + row - top);
        ASSERT_EQ(tile->bgra.at<cv::Vec4b>(row, column), update.projected->bgra.at<cv::Vec4b>(p));
        ++seen;
      }
    }
  }
  cv::Mat alpha;
  cv::extractChannel(update.projected->bgra, alpha, 3);
  EXPECT_EQ(seen, cv::countNonZero(alpha));
}

// The outline's 24 corners are rounded to the raster (0.71 px) and what its edges touch is filled
// (0.5 px); between two corners it lies inside the disc by 1 - cos(pi / 24) of the radius.
TEST_F(MosaickerTest, ShowsNothingWhereTheImageIsHidden) {
  Scene scene;
  scene.survey_from_camera = test::camera_at({0, 0, 2}, 35, 12);
  scene.plane = test::plane_through({0, 0, 0}, {0.3, -0.4, 1});
  const std::vector<Disc> hidden{{{120, 90}, 15}, {{300, 250}, 30}, {{478, 180}, 12}};
  const MosaicUpdate update =
      mosaicker_.process(test::surface_of(scene, test::grey_image(scene.camera), hidden));
  ASSERT_TRUE(update.projected);
  const cv::Mat& bgra = update.projected->bgra;
  const auto pixel_at = [&](int column, int row) {
    const Vector2d xy = update.projected->world(column, row);
    const Plane& plane = scene.plane;
    const double z = (plane.offset - plane.normal.head<2>().dot(xy)) / plane.normal.z();
    return scene.camera.project(scene.survey_from_camera.inverse() * Vector3d(xy.x(), xy.y(), z))
        .value();
  };
  std::vector<int> found(hidden.size());
  int shown = 0;
  for (int row = 0; row < bgra.rows; ++row) {
    for (int column = 0; column < bgra.cols; ++column) {
      const Vector2d pixel = pixel_at(column, row);
      const double inside = std::min({pixel.x(), pixel.y(), 483 - pixel.x(), 363 - pixel.y()});
      if (std::abs(inside) < 0.2) continue;
      const double raster_px = std::hypot((pixel_at(column + 1, row) - pixel).norm(),
                                          (pixel_at(column, row + 1) - pixel).norm());
      bool covered = false, doubtful = false;
      for (std::size_t i = 0; i < hidden.size(); ++i) {
        const double beyond = (pixel - hidden[i].pixel).norm() - hidden[i].radius_px;
        const double margin = 1.21 * raster_px + 0.0086 * hidden[i].radius_px;
        doubtful |= std::abs(beyond) < margin;
        covered |= beyond <= -margin;
        found[i] += inside > 0 && beyond <= -margin;
      }
      if (doubtful) continue;
      const int alpha = bgra.at<cv::Vec4b>(row, column)[3];
      ASSERT_EQ(alpha, inside > 0 && !covered ? 255 : 0) << pixel.transpose();
      shown += alpha == 255;
    }
  }
  for (std::size_t i = 0; i < hidden.size(); ++i) EXPECT_GT(found[i], 100) << i;
  EXPECT_GT(shown, 50000);
}

TEST_F(MosaickerTest, StartsANewMosaicWhenTheSeabedTurnsForGood) {
  see(sloping(0));
  EXPECT_TRUE(see(sloping(30)).alerts.empty());  // one departing plane is forgiven
  EXPECT_TRUE(see(sloping(0)).alerts.empty());
  EXPECT_EQ(see(sloping(30)).grid->mosaic, 0u);
  const MosaicUpdate second = see(sloping(30));
  EXPECT_EQ(second.grid->mosaic, 1u);
  ASSERT_EQ(second.alerts.size(), 1u);
  EXPECT_EQ(second.alerts[0].kind, AlertKind::mosaic_restarted);
  EXPECT_NE(second.alerts[0].message.find("turned by 30 degrees"), std::string::npos);
}

TEST_F(MosaickerTest, StartsANewMosaicWithASubmapAtOnce) {
  see(Scene{});
  Scene next;
  next.submap = 1;
  const MosaicUpdate update = see(next);
  EXPECT_EQ(update.grid->mosaic, 1u);
  EXPECT_EQ(update.grid->submap, 1u);
  ASSERT_EQ(update.alerts.size(), 1u);
}

TEST_F(MosaickerTest, WaitsWithoutAPlane) {
  auto surface = test::surface_of(Scene{}, test::grey_image(test::barrel_lens()));
  surface->plane.reset();
  const MosaicUpdate update = mosaicker_.process(surface);
  EXPECT_EQ(update.surface, surface);
  EXPECT_FALSE(update.grid || update.projected);
  const auto bare = std::make_shared<Surface>(Surface{std::make_shared<Orientation>(), {}, {}, {}});
  EXPECT_FALSE(mosaicker_.process(bare).grid);
}

TEST_F(MosaickerTest, SaysOnceThatAWallHasNoMosaic) {
  Scene wall = sloping(80);
  wall.survey_from_camera = test::camera_at({2, 0, 0});
  const MosaicUpdate first = see(wall);
  EXPECT_FALSE(first.grid);
  ASSERT_EQ(first.alerts.size(), 1u);
  EXPECT_EQ(first.alerts[0].kind, AlertKind::not_planar);
  EXPECT_TRUE(see(wall).alerts.empty());
  EXPECT_TRUE(see(Scene{}).grid);
}

TEST(MosaickerCanvas, NeverOutgrowsItsBudget) {
  Config config;
  config.max_megapixels = 1;
  config.ground_sampling_distance = 1e-7;  // asks for rasters of 10^14 px
  Mosaicker mosaicker(config);
  Scene scene;
  for (double height : {2.0, 3.0, 50.0, 1.0}) {
    scene.survey_from_camera = test::camera_at({0, 0, height}, 33, 25);
    const auto update = mosaicker.process(test::surface_of(scene, test::grey_image(scene.camera)));
    ASSERT_TRUE(update.projected) << height;
    EXPECT_LE(update.projected->bgra.total(), 1000000u);
    EXPECT_LE(update.tiles.size(), 50u);
  }
}

TEST(MosaickerCanvas, ClipsAViewAlmostAlongThePlane) {
  Mosaicker mosaicker{Config{}};
  Scene scene;
  for (double tilt : {50.0, 65.0, 69.0, 75.0, 89.9, 90.0}) {
    scene.survey_from_camera = test::camera_at({0, 0, 2}, 0, tilt);
    const auto update = mosaicker.process(test::surface_of(scene, test::grey_image(scene.camera)));
    if (!update.projected) continue;
    EXPECT_LE(update.projected->bgra.total(), 8000000u);
    const auto& p = *update.projected;
    for (const auto& [column, row] : {std::pair{0, 0}, {p.bgra.cols, p.bgra.rows}}) {
      EXPECT_LT(p.world(column, row).norm(), 9);  // max_range 3 at 2 m, by the diagonal
    }
  }
}

TEST(MosaickerCanvas, WorksInAnyUnit) {
  Mosaicker mosaicker{Config{}};
  Scene tiny;
  tiny.survey_from_camera = test::camera_at({0, 0, 2e-5});
  tiny.plane.rms = 1e-8;
  const auto update = mosaicker.process(test::surface_of(tiny, test::grey_image(tiny.camera)));
  ASSERT_TRUE(update.grid);
  EXPECT_NEAR(update.grid->ground_sampling_distance, 4.4e-8, 1e-15);
}

TEST(MosaickerConfig, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(Config{}.check());
  EXPECT_THROW(Config{.ground_sampling_distance = -1}.check(), InputError);
  EXPECT_THROW(Config{.max_megapixels = 1000}.check(), InputError);
  EXPECT_THROW(Config{.restart_after = 0}.check(), InputError);
}

}  // namespace
}  // namespace nadir::mosaic2d
