// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/projection3d/plane_projection.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "nadir/core/check.hpp"
#include "undistorted_grid.hpp"

namespace nadir::projection3d {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

CameraModel barrel_lens() {
  return {484, 364, 459, 458, 239.6, 183.7, LensModel::brown_conrady, {-0.25, 0.09, -5e-4, 6e-4}};
}
CameraModel pincushion_lens() {
  return {480, 270, 287, 287, 238.4, 136.1, LensModel::brown_conrady, {0.119, 0.036, 5e-4, -7e-4}};
}

// Smooth colours of the ground, so that means over a cell equal the value at its centre.
cv::Vec3d ground_colour(double x, double y) {
  return {127 + 90 * std::sin(2.1 * x), 127 + 90 * std::cos(1.7 * y), 127 + 90 * std::sin(x + y)};
}

struct Scene {
  Plane plane;
  Rigid3 survey_from_camera;
  CameraModel camera;

  Vector3d hit(const Vector2d& pixel) const {
    const auto ray = camera.unproject(pixel);
    const Vector3d direction = survey_from_camera.rotation * ray->homogeneous();
    const Vector3d& c = survey_from_camera.translation;
    return c - plane.distance(c) / plane.normal.dot(direction) * direction;
  }
};

Scene tilted_scene(const CameraModel& camera) {
  Scene scene;
  scene.camera = camera;
  scene.survey_from_camera = {(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitZ())) *
                               Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vector3d::UnitX())) *
                               Eigen::Quaterniond(0, 1, 0, 0))
                                  .normalized(),
                              {3, -2, -1}};
  scene.plane.normal = Vector3d(0.15, -0.1, 1).normalized();
  scene.plane.offset = scene.plane.normal.dot(Vector3d(3, -2, -3));
  return scene;
}

cv::Mat rendered(const Scene& scene) {
  cv::Mat image(scene.camera.height, scene.camera.width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const Vector3d x = scene.hit({u, v});
      const cv::Vec3d colour = ground_colour(x.x(), x.y());
      for (int c = 0; c < 3; ++c) {
        image.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<std::uint8_t>(colour[c]);
      }
    }
  }
  return image;
}

std::shared_ptr<Surface> surface_of(const Scene& scene, cv::Mat image) {
  auto rig = std::make_shared<CameraRig>();
  rig->left = scene.camera;
  auto frame = std::make_shared<Frame>();
  frame->rig = rig;
  frame->colour = std::move(image);
  auto window = std::make_shared<Window>();
  window->submap = 4;
  window->images.resize(3);
  window->images[1].image = 17;
  window->images[1].survey_from_camera = scene.survey_from_camera;
  window->central = frame;
  auto orientation = std::make_shared<Orientation>();
  orientation->window = window;
  auto surface = std::make_shared<Surface>();
  surface->orientation = orientation;
  surface->plane = scene.plane;
  return surface;
}

cv::Mat grey_image(const CameraModel& camera) {
  return {camera.height, camera.width, CV_8UC3, cv::Scalar::all(80)};
}

TEST(UndistortedGrid, FillsTheImageAndStaysInside) {
  for (const CameraModel& camera : {barrel_lens(), pincushion_lens()}) {
    const auto grid = undistorted_grid(camera, 150, 100);
    ASSERT_TRUE(grid);
    double margin = 1e9;
    for (const Vector2d& corner :
         {Vector2d(-0.5, -0.5), {149.5, -0.5}, {-0.5, 99.5}, {149.5, 99.5}}) {
      for (double t = 0; t <= 1; t += 0.05) {
        const Vector2d edge = corner + t * (Vector2d(149 - corner.x(), corner.y()) - corner);
        const auto pixel = camera.project(grid->camera_from_grid * edge.homogeneous());
        ASSERT_TRUE(pixel);
        margin = std::min({margin, pixel->x(), pixel->y(), camera.width - 1 - pixel->x(),
                           camera.height - 1 - pixel->y()});
      }
    }
    EXPECT_GT(margin, -0.1);
    EXPECT_LT(margin, 0.5);
  }
}

TEST(PlaneProjection, PutsEachCellWhereItsRayMeetsThePlane) {
  for (const CameraModel& camera : {barrel_lens(), pincushion_lens()}) {
    const Scene scene = tilted_scene(camera);
    const Cloud cloud = PlaneProjection(Config{}).process(surface_of(scene, grey_image(camera)));
    ASSERT_TRUE(cloud.grid);
    EXPECT_EQ(cloud.grid->image, 17u);
    EXPECT_EQ(cloud.grid->submap, 4u);
    ASSERT_EQ(cloud.grid->bgr.size(), cv::Size(150, 100));
    const auto points = cloud.grid->points();
    ASSERT_EQ(points.size(), 15000u);
    const auto grid = undistorted_grid(camera, 150, 100);
    for (std::size_t i = 0; i < points.size(); i += 97) {
      EXPECT_NEAR(scene.plane.distance(points[i].x_in_survey), 0, 1e-9);
      const Vector3d cell(static_cast<double>(i % 150), static_cast<double>(i / 150), 1);
      const auto pixel = camera.project(grid->camera_from_grid * cell);
      EXPECT_LT((scene.hit(*pixel) - points[i].x_in_survey).norm(), 1e-8);
    }
  }
}

TEST(PlaneProjection, IsCentredOnTheImageCentre) {
  Scene scene = tilted_scene(barrel_lens());
  scene.plane.normal = scene.survey_from_camera.rotation * -Vector3d::UnitZ();  // seen squarely
  scene.plane.offset = scene.plane.normal.dot(Vector3d(3, -2, -3));
  const Cloud cloud =
      PlaneProjection(Config{}).process(surface_of(scene, grey_image(scene.camera)));
  ASSERT_TRUE(cloud.grid);
  Vector3d mean = Vector3d::Zero();
  for (const CloudPoint& p : cloud.grid->points()) mean += p.x_in_survey / 15000;
  EXPECT_LT((mean - scene.hit({241.5, 181.5})).norm(), 1e-8);
}

TEST(PlaneProjection, ColoursThePointsAsTheGroundIs) {
  const Scene scene = tilted_scene(barrel_lens());
  const Cloud cloud = PlaneProjection(Config{}).process(surface_of(scene, rendered(scene)));
  ASSERT_TRUE(cloud.grid);
  double worst = 0;
  for (const CloudPoint& p : cloud.grid->points()) {
    const cv::Vec3d bgr = ground_colour(p.x_in_survey.x(), p.x_in_survey.y());
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(bgr[c] - p.rgb[static_cast<std::size_t>(2 - c)]));
    }
  }
  EXPECT_LT(worst, 2.0);  // rounding of the image, of the samples and of their mean
}

TEST(PlaneProjection, ColoursAGridOfFewCellsAsTruly) {
  const Scene scene = tilted_scene(barrel_lens());
  Config config;
  config.columns = 30;
  config.rows = 20;  // 19 pixels across a cell: the image is reduced first
  const Cloud cloud = PlaneProjection(config).process(surface_of(scene, rendered(scene)));
  ASSERT_TRUE(cloud.grid);
  for (const CloudPoint& p : cloud.grid->points()) {
    const cv::Vec3d bgr = ground_colour(p.x_in_survey.x(), p.x_in_survey.y());
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(bgr[c], p.rgb[static_cast<std::size_t>(2 - c)], 3);
    }
  }
}

TEST(PlaneProjection, AveragesThePixelsOfACell) {
  const Scene scene = tilted_scene({480, 320, 400, 400, 239.5, 159.5});
  cv::Mat checks(320, 480, CV_8UC3);
  for (int v = 0; v < checks.rows; ++v) {
    for (int u = 0; u < checks.cols; ++u) {
      checks.at<cv::Vec3b>(v, u) = cv::Vec3b::all((u + v) % 2 == 0 ? 0 : 200);
    }
  }
  Config config;
  config.columns = 48;
  config.rows = 32;
  const Cloud cloud = PlaneProjection(config).process(surface_of(scene, checks));
  ASSERT_TRUE(cloud.grid);
  double least = 255, most = 0;
  cv::minMaxLoc(cloud.grid->bgr.reshape(1), &least, &most);
  EXPECT_GT(least, 85);  // a point sample would see 0 or 200
  EXPECT_LT(most, 115);
}

TEST(PlaneProjection, CutsRaysThatGrazeThePlane) {
  Scene scene = tilted_scene(pincushion_lens());
  scene.survey_from_camera.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Vector3d::UnitX())) *
      Eigen::Quaterniond(0, 1, 0, 0);
  scene.plane.normal = Vector3d::UnitZ();
  scene.plane.offset = -3;
  const Cloud cloud =
      PlaneProjection(Config{}).process(surface_of(scene, grey_image(scene.camera)));
  ASSERT_TRUE(cloud.grid);
  const auto points = cloud.grid->points();
  EXPECT_GT(points.size(), 1000u);
  EXPECT_LT(points.size(), 15000u);
  for (const CloudPoint& p : points) {
    EXPECT_LE((p.x_in_survey - scene.survey_from_camera.translation).norm(), 6 + 1e-9);
  }
}

TEST(PlaneProjection, HasNoGridWithoutAPlaneInFrontOfTheCamera) {
  Scene scene = tilted_scene(barrel_lens());
  PlaneProjection projection{Config{}};
  auto none = surface_of(scene, grey_image(scene.camera));
  none->plane.reset();
  EXPECT_FALSE(projection.process(none).grid);
  Scene behind = scene;
  behind.plane.offset += 10;
  EXPECT_FALSE(projection.process(surface_of(behind, grey_image(scene.camera))).grid);
  Scene edge_on = scene;
  edge_on.plane.normal = scene.survey_from_camera.rotation * Vector3d::UnitX();
  edge_on.plane.offset = edge_on.plane.normal.dot(scene.survey_from_camera.translation) - 0.5;
  EXPECT_FALSE(projection.process(surface_of(edge_on, grey_image(scene.camera))).grid);
  const auto windowless =
      std::make_shared<Surface>(Surface{std::make_shared<Orientation>(), {}, {}, {}});
  EXPECT_FALSE(projection.process(windowless).grid);
}

TEST(PlaneProjection, FollowsAChangeOfCamera) {
  PlaneProjection projection{Config{}};
  for (const CameraModel& camera : {barrel_lens(), pincushion_lens(), barrel_lens()}) {
    const Scene scene = tilted_scene(camera);
    const auto surface = surface_of(scene, rendered(scene));
    const Cloud kept = projection.process(surface);
    const Cloud fresh = PlaneProjection(Config{}).process(surface);
    ASSERT_TRUE(kept.grid && fresh.grid);
    EXPECT_EQ(kept.grid->survey_from_grid, fresh.grid->survey_from_grid);
    EXPECT_EQ(cv::norm(kept.grid->bgr, fresh.grid->bgr, cv::NORM_INF), 0);
  }
}

TEST(PlaneProjection, KeepsAMillimetreAMillionMetresFromTheOrigin) {
  const Scene scene = tilted_scene(barrel_lens());
  Scene distant = scene;
  const Vector3d shift(1e6, -1e6, 10);
  distant.survey_from_camera.translation += shift;
  distant.plane.offset += scene.plane.normal.dot(shift);
  const Cloud a = PlaneProjection(Config{}).process(surface_of(scene, grey_image(scene.camera)));
  const Cloud b = PlaneProjection(Config{}).process(surface_of(distant, grey_image(scene.camera)));
  ASSERT_TRUE(a.grid && b.grid);
  const auto near = a.grid->points(), far = b.grid->points();
  ASSERT_EQ(near.size(), far.size());
  for (std::size_t i = 0; i < near.size(); i += 31) {
    EXPECT_LT((near[i].x_in_survey + shift - far[i].x_in_survey).norm(), 1e-3);
  }
}

TEST(Projection3dConfig, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(Config{}.check());
  EXPECT_THROW(Config{.columns = 1}.check(), InputError);
  EXPECT_THROW(Config{.max_range = 1}.check(), InputError);
}

}  // namespace
}  // namespace nadir::projection3d
