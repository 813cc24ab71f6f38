// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A camera over a plane whose colours are a function of survey X and Y.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>

#include "nadir/core/surface.hpp"

namespace nadir::mosaic2d::test {

inline CameraModel barrel_lens() {
  return {484, 364, 459, 458, 239.6, 183.7, LensModel::brown_conrady, {-0.25, 0.09, -5e-4, 6e-4}};
}
inline CameraModel pincushion_lens() {
  return {480, 270, 287, 287, 238.4, 136.1, LensModel::brown_conrady, {0.119, 0.036, 5e-4, -7e-4}};
}

inline Plane plane_through(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) {
  Plane plane;
  plane.normal = normal.normalized();
  plane.offset = plane.normal.dot(x);
  plane.centroid = x;
  plane.inliers = 100;
  plane.inlier_ratio = 1;
  plane.rms = 0.001;
  return plane;
}

/// Looking down with the image top to the north, then turned clockwise by yaw and tilted.
inline Rigid3 camera_at(const Eigen::Vector3d& x, double yaw_deg = 0, double tilt_deg = 0) {
  const double degree = std::numbers::pi / 180;
  const Eigen::Quaterniond down(0, 1, 0, 0);
  return {
      (Eigen::Quaterniond(Eigen::AngleAxisd(-yaw_deg * degree, Eigen::Vector3d::UnitZ())) *
       Eigen::Quaterniond(Eigen::AngleAxisd(tilt_deg * degree, Eigen::Vector3d::UnitX())) * down)
          .normalized(),
      x};
}

struct Scene {
  CameraModel camera = barrel_lens();
  Rigid3 survey_from_camera = camera_at({0, 0, 2});
  Plane plane = plane_through({0, 0, 0}, {0, 0, 1});
  std::uint32_t submap = 0;
  std::uint64_t image = 0;
};

using Colours = std::function<cv::Vec3d(double x, double y)>;

inline cv::Mat render(const Scene& scene, const Colours& colours) {
  cv::Mat image = cv::Mat::zeros(scene.camera.height, scene.camera.width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto ray = scene.camera.unproject(Eigen::Vector2d(u, v));
      if (!ray) continue;
      const Eigen::Vector3d direction = scene.survey_from_camera.rotation * ray->homogeneous();
      const Eigen::Vector3d& c = scene.survey_from_camera.translation;
      const double range = -scene.plane.distance(c) / scene.plane.normal.dot(direction);
      if (!(range > 0)) continue;
      const Eigen::Vector3d x = c + range * direction;
      const cv::Vec3d colour = colours(x.x(), x.y());
      for (int k = 0; k < 3; ++k) {
        image.at<cv::Vec3b>(v, u)[k] = cv::saturate_cast<std::uint8_t>(colour[k]);
      }
    }
  }
  return image;
}

inline std::shared_ptr<Surface> surface_of(const Scene& scene, cv::Mat image,
                                           std::vector<Disc> hidden = {}) {
  auto rig = std::make_shared<CameraRig>();
  rig->left = scene.camera;
  auto frame = std::make_shared<Frame>();
  frame->rig = rig;
  frame->colour = std::move(image);
  frame->hidden = std::move(hidden);
  auto window = std::make_shared<Window>();
  window->submap = scene.submap;
  window->images.resize(3);
  window->images[1].image = scene.image;
  window->images[1].survey_from_camera = scene.survey_from_camera;
  window->central = frame;
  auto orientation = std::make_shared<Orientation>();
  orientation->window = window;
  auto surface = std::make_shared<Surface>();
  surface->orientation = orientation;
  surface->plane = scene.plane;
  return surface;
}

inline cv::Mat grey_image(const CameraModel& camera) {
  return {camera.height, camera.width, CV_8UC3, cv::Scalar::all(80)};
}

}  // namespace nadir::mosaic2d::test
