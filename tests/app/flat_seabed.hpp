// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Messages of a vehicle over a flat seabed at z = 0, without pixels.
#pragma once

#include <cmath>

#include "nadir/core/cloud.hpp"

namespace nadir::app {

constexpr int kViewWidth = 400, kViewHeight = 300;
constexpr double kViewFocal = 400;  // at height h an image shows h by 0.75 h

inline std::shared_ptr<const CameraRig> flat_rig() {
  static const auto rig = [] {
    CameraRig made;
    made.left = {kViewWidth, kViewHeight, kViewFocal, kViewFocal, 199.5, 149.5, {}, {}};
    return std::make_shared<const CameraRig>(made);
  }();
  return rig;
}

/// Looks down; heading clockwise from y.
inline Rigid3 looking_down_at(double x, double y, double height, double heading = 0) {
  Eigen::Matrix3d rotation;
  rotation.col(0) = Eigen::Vector3d(std::cos(heading), -std::sin(heading), 0);
  rotation.col(1) = -Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
  rotation.col(2) = -Eigen::Vector3d::UnitZ();
  return {Eigen::Quaterniond(rotation), {x, y, height}};
}

/// Tracked, with a window of its own.
inline Orientation seen_from(std::uint64_t image, double time_s, const Rigid3& pose,
                             Scale scale = {ScaleSource::stereo, 0.001}) {
  auto frame = std::make_shared<Frame>();
  frame->image = image;
  frame->time = from_seconds(time_s);
  frame->rig = flat_rig();
  auto shot = std::make_shared<Shot>();
  shot->image = image;
  shot->time = frame->time;
  shot->frame = frame;
  auto window = std::make_shared<Window>();
  window->scale = scale;
  window->axes = SurveyAxes::attitude;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const Eigen::Vector3d& at = pose.translation;
      window->tie_points.push_back(
          {0, {at.x() + 0.1 * at.z() * i, at.y() + 0.1 * at.z() * j, 0}, {}, 3, 0.2});
    }
  }
  Orientation orientation;
  orientation.state = TrackingState::tracking;
  orientation.axes = SurveyAxes::attitude;
  orientation.poses.push_back({image, shot->time, 0, pose, true, 200, 0.3});
  window->images = orientation.poses;
  orientation.shot = shot;
  orientation.window = window;
  orientation.health.sharpness = 80;
  orientation.health.exposure = 51;
  return orientation;
}

/// What the same image shows.
inline Cloud ground_of(std::uint64_t image, const Rigid3& pose) {
  Grid grid;
  grid.image = image;
  grid.bgr = cv::Mat(15, 20, CV_8UC3);
  grid.camera_in_survey = pose.translation;
  grid.max_range = 100;
  Eigen::Matrix3d camera_from_grid;
  camera_from_grid << 1.0 / 20, 0, -9.5 / 20, 0, 1.0 / 20, -7.0 / 20, 0, 0, 1;
  const Eigen::Matrix3d rays = pose.rotation.toRotationMatrix() * camera_from_grid;
  const Eigen::RowVector3d w = -rays.row(2);
  grid.survey_from_grid << pose.translation.z() * rays + pose.translation * w, w;
  Cloud cloud;
  cloud.grid = grid;
  return cloud;
}

}  // namespace nadir::app
