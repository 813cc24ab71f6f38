// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plane_homography.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "mosaic2d/scene.hpp"

namespace nadir::mosaic2d {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using test::Scene;

View view_of(const Scene& scene, double max_range = 20) {
  return {scene.camera, scene.survey_from_camera, scene.plane, max_range};
}

MosaicGrid grid_at(const Vector2d& x, double gsd) {
  MosaicGrid grid;
  grid.ground_sampling_distance = gsd;
  grid.world = {gsd, 0, 0, -gsd, x.x(), x.y()};
  return grid;
}

ProjectedImage projected(const Scene& scene, const cv::Mat& image, const MosaicGrid& grid) {
  const View view = view_of(scene);
  const auto seen = footprint(view);
  EXPECT_TRUE(seen);
  const auto pixels = raster(*seen, grid, 8e6);
  EXPECT_TRUE(pixels);
  return project_image(image, view, grid, *pixels);
}

Scene tilted(const CameraModel& camera, double yaw_deg, double tilt_deg,
             const Vector3d& at = Vector3d::Zero()) {
  Scene scene;
  scene.camera = camera;
  scene.survey_from_camera = test::camera_at(at + Vector3d(0, 0, 2), yaw_deg, tilt_deg);
  scene.plane = test::plane_through(at, {0.12, -0.2, 1});
  return scene;
}

// A disc of Gaussian brightness on dark ground: its centroid is its centre within 1/20 px.
test::Colours spot(const Vector2d& centre, double sigma) {
  return [=](double x, double y) {
    const double d2 = (Vector2d(x, y) - centre).squaredNorm();
    return cv::Vec3d::all(250 * std::exp(-d2 / (2 * sigma * sigma)));
  };
}

Vector2d centroid(const ProjectedImage& image) {
  Vector2d sum = Vector2d::Zero();
  double weight = 0;
  for (int row = 0; row < image.bgra.rows; ++row) {
    for (int column = 0; column < image.bgra.cols; ++column) {
      const double value = image.bgra.at<cv::Vec4b>(row, column)[1];
      sum += value * image.world(column, row);
      weight += value;
    }
  }
  return sum / weight;
}

struct Case {
  CameraModel camera;
  double yaw_deg, tilt_deg;
  Vector3d at;
};

class ProjectedSpot : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Views, ProjectedSpot,
                         testing::Values(Case{test::barrel_lens(), 0, 0, {0, 0, 0}},
                                         Case{test::barrel_lens(), 37, 12, {5, -3, -7}},
                                         Case{test::pincushion_lens(), 200, -20, {0, 0, -3}},
                                         Case{test::barrel_lens(), 90, 5, {1e6, -1e6, 0}}));

TEST_P(ProjectedSpot, LiesWhereTheWorldFileSays) {
  const auto& [camera, yaw, tilt, at] = GetParam();
  const Scene scene = tilted(camera, yaw, tilt, at);
  const View view = view_of(scene);
  const MosaicGrid grid = grid_at(at.head<2>() + Vector2d(0.4, 0.7), 0.005);
  for (const Vector2d& pixel : {Vector2d(60, 50), {240, 130}, {400, 210}}) {
    const auto truth = ground_point(view, pixel);
    ASSERT_TRUE(truth);
    const cv::Mat image = test::render(scene, spot(truth->head<2>(), 0.03));
    const Vector2d found = centroid(projected(scene, image, grid));
    EXPECT_LT((found - truth->head<2>()).norm() / 0.005, 0.1) << pixel.transpose();
  }
}

TEST(ProjectImage, IsNorthUpAndNotMirrored) {
  const Scene scene;
  const cv::Mat image = test::render(scene, [](double x, double y) {
    return cv::Vec3d(x > 0 ? 200 : 0, y > 0 ? 200 : 0, 100);  // blue in the east, green north
  });
  const ProjectedImage p = projected(scene, image, grid_at({0, 0}, 0.005));
  const int right = p.bgra.cols * 3 / 4, left = p.bgra.cols / 4;
  const int top = p.bgra.rows / 4, bottom = p.bgra.rows * 3 / 4;
  EXPECT_EQ(p.bgra.at<cv::Vec4b>(top, right), cv::Vec4b(200, 200, 100, 255));
  EXPECT_EQ(p.bgra.at<cv::Vec4b>(top, left), cv::Vec4b(0, 200, 100, 255));
  EXPECT_EQ(p.bgra.at<cv::Vec4b>(bottom, right), cv::Vec4b(200, 0, 100, 255));
  EXPECT_GT(p.world.a, 0);
  EXPECT_LT(p.world.e, 0);
}

TEST(ProjectImage, IsOpaqueInsideAndEmptyOutsideTheImage) {
  const Scene scene = tilted(test::barrel_lens(), 30, 10);
  const ProjectedImage p = projected(scene, test::grey_image(scene.camera), grid_at({0, 0}, 0.004));
  int inside = 0;
  for (int row = 0; row < p.bgra.rows; ++row) {
    for (int column = 0; column < p.bgra.cols; ++column) {
      const Vector2d xy = p.world(column, row);
      const Plane& plane = scene.plane;
      const double z = (plane.offset - plane.normal.head<2>().dot(xy)) / plane.normal.z();
      const auto pixel =
          scene.camera.project(scene.survey_from_camera.inverse() * Vector3d(xy.x(), xy.y(), z));
      ASSERT_TRUE(pixel);
      const double margin = std::min({pixel->x(), pixel->y(), 483 - pixel->x(), 363 - pixel->y()});
      const cv::Vec4b& value = p.bgra.at<cv::Vec4b>(row, column);
      if (std::abs(margin) < 0.2) continue;
      ASSERT_EQ(value, margin > 0 ? cv::Vec4b(80, 80, 80, 255) : cv::Vec4b())
          << column << ' ' << row;
      inside += margin > 0.2;
    }
  }
  EXPECT_GT(inside, 50000);
}

// Neighbours differ by 31 at most and places are rounded to 1/32 px: half of that in both
// directions, and half a grey level for the rounding of values.
TEST(ProjectImage, IsBilinear) {
  Scene scene;
  scene.camera = {483, 357, 460, 460, 240.3, 178.8, LensModel::brown_conrady, {}};
  scene.survey_from_camera = test::camera_at({0, 0, 2}, 33);
  cv::Mat image = test::grey_image(scene.camera);
  std::mt19937 random(5);
  for (auto& value : cv::Mat_<cv::Vec3b>(image)) {
    for (int k = 0; k < 3; ++k) value[k] = static_cast<std::uint8_t>(100 + random() % 32);
  }
  const ProjectedImage p = projected(scene, image, grid_at({0, 0}, 0.004));
  double sum = 0;
  int count = 0;
  for (int row = 0; row < p.bgra.rows; ++row) {
    for (int column = 0; column < p.bgra.cols; ++column) {
      const cv::Vec4b& found = p.bgra.at<cv::Vec4b>(row, column);
      if (found[3] == 0) continue;
      const Vector2d xy = p.world(column, row);
      const auto pixel =
          scene.camera.project(scene.survey_from_camera.inverse() * Vector3d(xy.x(), xy.y(), 0));
      ASSERT_TRUE(pixel);
      const int u = std::clamp(static_cast<int>(pixel->x()), 0, image.cols - 2);
      const int v = std::clamp(static_cast<int>(pixel->y()), 0, image.rows - 2);
      const double a = pixel->x() - u, b = pixel->y() - v;
      const cv::Vec3d wanted = (1 - b) * ((1 - a) * cv::Vec3d(image.at<cv::Vec3b>(v, u)) +
                                          a * cv::Vec3d(image.at<cv::Vec3b>(v, u + 1))) +
                               b * ((1 - a) * cv::Vec3d(image.at<cv::Vec3b>(v + 1, u)) +
                                    a * cv::Vec3d(image.at<cv::Vec3b>(v + 1, u + 1)));
      for (int k = 0; k < 3; ++k) {
        const double error = found[k] - wanted[k];
        ASSERT_LT(std::abs(error), 31.0 * 2 / 64 + 0.5 + 0.1) << column << ' ' << row;
        sum += error;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 3 * 50000);
  // Halves are rounded up; cut instead, it would be -0.1 or less.
  EXPECT_NEAR(sum / count, 0, 0.06);
}

TEST(ProjectImage, TwoImagesOfOnePlaneAgree) {
  const auto texture = [](double x, double y) {
    return cv::Vec3d(127 + 60 * std::sin(30 * x), 127 + 60 * std::cos(25 * y),
                     127 + 60 * std::sin(20 * (x + y)));
  };
  const Scene a = tilted(test::barrel_lens(), 20, 6);
  Scene b = tilted(test::barrel_lens(), 115, -8);
  b.survey_from_camera.translation += Vector3d(0.2, -0.15, 0.3);
  const MosaicGrid grid = grid_at({0, 0}, 0.005);
  const ProjectedImage pa = projected(a, test::render(a, texture), grid);
  const ProjectedImage pb = projected(b, test::render(b, texture), grid);
  const int dx = static_cast<int>(std::lround((pb.world.c - pa.world.c) / 0.005));
  const int dy = static_cast<int>(std::lround((pa.world.f - pb.world.f) / 0.005));
  const cv::Rect ra({0, 0}, pa.bgra.size()), common = ra & cv::Rect({dx, dy}, pb.bgra.size());
  double sum = 0;
  int count = 0;
  for (int row = common.y; row < common.y + common.height; ++row) {
    for (int column = common.x; column < common.x + common.width; ++column) {
      const cv::Vec4b& va = pa.bgra.at<cv::Vec4b>(row, column);
      const cv::Vec4b& vb = pb.bgra.at<cv::Vec4b>(row - dy, column - dx);
      if (va[3] == 0 || vb[3] == 0) continue;
      const double d = static_cast<double>(va[0]) - vb[0];
      sum += d * d;
      ++count;
    }
  }
  ASSERT_GT(count, 50000);
  // One pixel of shift would be 60 * 30 * 0.005 / sqrt(2) = 6.4 grey levels RMS.
  EXPECT_LT(std::sqrt(sum / count), 1.0);
}

TEST(ProjectImage, AveragesWhereTheRasterIsMuchCoarser) {
  const Scene scene;
  cv::Mat checks = test::grey_image(scene.camera);
  for (int v = 0; v < checks.rows; ++v) {
    for (int u = 0; u < checks.cols; ++u) {
      checks.at<cv::Vec3b>(v, u) = cv::Vec3b::all((u / 2 + v / 2) % 2 == 0 ? 0 : 200);
    }
  }
  const double gsd = 4.5 * 2 / scene.camera.fx;
  const ProjectedImage p = projected(scene, checks, grid_at({0, 0}, gsd));
  for (int row = 0; row < p.bgra.rows; ++row) {
    for (int column = 0; column < p.bgra.cols; ++column) {
      const cv::Vec4b& value = p.bgra.at<cv::Vec4b>(row, column);
      if (value[3] != 0) {
        EXPECT_NEAR(value[0], 100, 2);
      }
    }
  }
}

TEST(ProjectImage, EndsWhereTheLensModelFolds) {
  Scene scene;
  scene.camera.distortion = {-0.6, 0, 0, 0, 0};  // r (1 - 0.6 r^2) turns back at r = 0.745
  scene.camera.fx = scene.camera.fy = 300;       // the image's corners lie beyond
  const ProjectedImage p = projected(scene, test::grey_image(scene.camera), grid_at({0, 0}, 0.005));
  const double reach = 2 * 0.745 + 0.01;
  for (int row = 0; row < p.bgra.rows; ++row) {
    for (int column = 0; column < p.bgra.cols; ++column) {
      if (p.bgra.at<cv::Vec4b>(row, column)[3] != 0) {
        EXPECT_LT(p.world(column, row).norm(), reach);
      }
    }
  }
}

TEST(Footprint, IsCutWhereRaysGrazeThePlane) {
  Scene scene;
  scene.survey_from_camera = test::camera_at({0, 0, 2}, 0, 60);
  const auto seen = footprint(view_of(scene, 6));
  ASSERT_TRUE(seen);
  EXPECT_LT((seen->most - seen->least).norm(), 20);
  scene.survey_from_camera = test::camera_at({0, 0, 2}, 0, 90);
  EXPECT_FALSE(footprint(view_of(scene, 6)));
  scene.survey_from_camera = test::camera_at({0, 0, -2});
  EXPECT_FALSE(footprint(view_of(scene, 6)));
}

TEST(Footprint, KnowsTheImagesOwnSamplingDistance) {
  const auto seen = footprint(view_of(Scene{}));
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->sampling_distance, 2.0 / 459, 1e-9);
  EXPECT_NEAR(seen->viewing_distance, 2.0, 1e-4);
}

TEST(Raster, RefusesMoreThanTheCanvasAllows) {
  const auto seen = footprint(view_of(Scene{}));
  ASSERT_TRUE(seen);
  EXPECT_TRUE(raster(*seen, grid_at({0, 0}, 0.005), 1e6));
  EXPECT_FALSE(raster(*seen, grid_at({0, 0}, 1e-6), 8e6));
  EXPECT_FALSE(raster(*seen, grid_at({1e7, 0}, 0.005), 1e6));
}

}  // namespace
}  // namespace nadir::mosaic2d
