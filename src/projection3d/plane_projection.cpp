// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/projection3d/plane_projection.hpp"

#include <opencv2/imgproc.hpp>

#include "nadir/core/check.hpp"
#include "nadir/image_io/reduce.hpp"
#include "undistorted_grid.hpp"

namespace nadir::projection3d {
namespace {

using Eigen::Vector3d;

// A point is camera + s ray with normal . point = offset, so s = -distance / (normal . ray);
// homogeneous with w = -normal . ray, which is positive where the ray meets the plane.
Eigen::Matrix<double, 4, 3> survey_from_grid(const Plane& plane, const Rigid3& survey_from_camera,
                                             const Eigen::Matrix3d& camera_from_grid) {
  const Vector3d& camera = survey_from_camera.translation;
  const Eigen::Matrix3d rays = survey_from_camera.rotation * camera_from_grid;
  const Eigen::RowVector3d w = -plane.normal.transpose() * rays;
  Eigen::Matrix<double, 4, 3> h;
  h << plane.distance(camera) * rays + camera * w, w;
  return h;
}

bool centre_in_range(const Grid& grid) {
  const Eigen::Vector4d h =
      grid.survey_from_grid * Vector3d((grid.bgr.cols - 1) / 2.0, (grid.bgr.rows - 1) / 2.0, 1);
  return h(3) > 0 && (h.head<3>() / h(3) - grid.camera_in_survey).norm() <= grid.max_range;
}

cv::Mat cell_means(const cv::Mat& image, const UndistortedGrid& lens, int columns, int rows) {
  cv::Mat fine, cells;
  cv::remap(image_io::reduce(image, lens.divisor), fine, lens.pixels, lens.fractions,
            cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::resize(fine, cells, {columns, rows}, 0, 0, cv::INTER_AREA);
  return cells;
}

}  // namespace

struct PlaneProjection::Lens {
  std::shared_ptr<const CameraRig> rig;
  std::optional<UndistortedGrid> grid;
};

void Config::check() const {
  require_setting(columns >= 2 && columns <= 1000, "projection3d.columns", "2 to 1000");
  require_setting(rows >= 2 && rows <= 1000, "projection3d.rows", "2 to 1000");
  require_setting(max_range > 1 && max_range <= 100, "projection3d.max_range",
                  "above 1 and at most 100 (a ratio of the distance to the plane)");
}

PlaneProjection::PlaneProjection(const Config& config) : config_(config) {}
PlaneProjection::~PlaneProjection() = default;

const PlaneProjection::Lens& PlaneProjection::lens_of(const std::shared_ptr<const CameraRig>& rig) {
  if (!lens_ || lens_->rig != rig) {
    lens_ = std::make_unique<const Lens>(
        Lens{rig, undistorted_grid(rig->left, config_.columns, config_.rows)});
  }
  return *lens_;
}

Cloud PlaneProjection::process(std::shared_ptr<const Surface> surface) {
  Cloud cloud;
  cloud.surface = std::move(surface);
  if (!cloud.surface->plane) return cloud;
  const Plane& plane = *cloud.surface->plane;
  const Window& window = *cloud.surface->window();
  const Rigid3& pose = window.central_pose().survey_from_camera;
  const double distance = plane.distance(pose.translation);
  const Lens& lens = lens_of(window.central->rig);
  if (!lens.grid || !(distance > 0)) return cloud;

  Grid grid;
  grid.image = window.central_pose().image;
  grid.submap = window.submap;
  grid.survey_from_grid = survey_from_grid(plane, pose, lens.grid->camera_from_grid);
  grid.camera_in_survey = pose.translation;
  grid.max_range = config_.max_range * distance;
  grid.bgr = cell_means(window.central->colour, *lens.grid, config_.columns, config_.rows);
  if (centre_in_range(grid)) cloud.grid = std::move(grid);
  return cloud;
}

}  // namespace nadir::projection3d
