// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "outputs.hpp"

#include <algorithm>
#include <array>

namespace nadir::app {
namespace {

constexpr Time kOutlinePeriod = 5'000'000'000;

std::optional<sensors::Pose> pose_of(const Orientation& orientation) {
  const Shot& shot = *orientation.shot;
  const auto oriented = std::ranges::find(orientation.poses, shot.image, &ImagePose::image);
  sensors::Pose pose;
  Rigid3 survey_from_camera;
  if (oriented != orientation.poses.end()) {
    survey_from_camera = oriented->survey_from_camera;
    pose.tracked = true;
    pose.position_sigma = oriented->sigma_position;
    pose.angle_sigma = oriented->sigma_rotation;
  } else if (orientation.dead_reckoned) {
    survey_from_camera = orientation.dead_reckoned->survey_from_camera;
    pose.position_sigma = orientation.dead_reckoned->sigma_position;
  } else {
    return std::nullopt;
  }
  pose.time = shot.time;
  pose.image = shot.image;
  pose.submap = orientation.submap;
  pose.position = survey_from_camera.translation;
  pose.survey_from_body =
      survey_from_camera.rotation * shot.frame->rig->body_from_camera.conjugate();
  return pose;
}

}  // namespace

Outputs::Outputs(const Config& config)
    : output_(sensors::parse_outputs(config.sensors.outputs), config.sensors.mavlink_system) {
  if (const auto origin = reference::parse_origin(config.reference.origin)) grid_.emplace(*origin);
}

void Outputs::process(const Orientation& orientation) {
  if (orientation.window) scale_ = orientation.window->scale;
  if (orientation.window && orientation.axes == SurveyAxes::none) axes_ = orientation.window->axes;
  if (orientation.axes != SurveyAxes::none) axes_ = orientation.axes;
  if (!orientation.shot || !orientation.shot->frame) return;
  std::optional<sensors::Pose> pose = pose_of(orientation);
  if (!pose) return;
  pose->metric = scale_.source != ScaleSource::none;
  pose->north = axes_ == SurveyAxes::attitude;
  if (grid_ && pose->north) pose->convergence = grid_->convergence();
  if (grid_ && pose->north && pose->metric) {
    if (const auto place = grid_->geodetic(pose->position))
      pose->geodetic = sensors::Position{place->latitude_deg, place->longitude_deg, {}};
  }
  output_.send(*pose);
}

void Outputs::process(const Cloud& cloud) {
  if (!cloud.grid || !cloud.surface->plane) return;
  const Grid& grid = *cloud.grid;
  sensors::Ground ground{grid.image, grid.submap, cloud.surface->plane->normal, {}};
  std::vector<Eigen::Vector2d> footprint;
  const double right = grid.bgr.cols - 1, bottom = grid.bgr.rows - 1;
  for (const Eigen::Vector2d& cell :
       {Eigen::Vector2d(0, 0), {right, 0}, {right, bottom}, {0, bottom}}) {
    const Eigen::Vector4d corner = grid.survey_from_grid * cell.homogeneous();
    const Eigen::Vector3d x_in_survey = corner.hnormalized();
    // Beyond its range, or behind the camera, the plane is not what the image shows.
    if (!((x_in_survey - grid.camera_in_survey).norm() <= grid.max_range)) return;
    ground.footprint.push_back(x_in_survey);
    footprint.push_back(x_in_survey.head<2>());
  }
  output_.send(ground);
  seen_.add(footprint);
  const Shot* shot = cloud.surface->orientation->shot.get();
  if (!shot || (outlined_ && shot->time - *outlined_ < kOutlinePeriod)) return;
  outlined_ = shot->time;
  coverage::SeenGround seen = seen_;  // stays as fine as it is
  while (!output_.send(seen.outline())) seen.coarsen();
}

}  // namespace nadir::app
