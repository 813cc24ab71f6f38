// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_speed.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace nadir::app {

std::optional<double> ImageSpeed::observe(const Orientation& orientation) {
  if (orientation.window) window_ = orientation.window;
  const Shot* shot = orientation.shot.get();
  if (!shot || !shot->frame || !shot->frame->rig) return std::nullopt;
  const auto newest =
      std::ranges::find(orientation.poses, orientation.shot->image, &ImagePose::image);
  if (newest == orientation.poses.end()) {
    before_.reset();
    return std::nullopt;
  }
  const std::optional<ImagePose> before = std::exchange(before_, *newest);
  if (!before || before->submap != newest->submap || !window_) return std::nullopt;
  const double elapsed_s = seconds(newest->time - before->time);
  if (elapsed_s <= 0) return std::nullopt;
  const CameraModel& camera = orientation.shot->frame->rig->left;
  const Rigid3 camera_from_survey = newest->survey_from_camera.inverse();
  const Rigid3 before_from_survey = before->survey_from_camera.inverse();
  std::vector<double> moved;
  for (const TiePoint& point : window_->tie_points) {
    const auto now = camera.project(camera_from_survey * point.x_in_survey);
    const auto then = camera.project(before_from_survey * point.x_in_survey);
    if (now && then) moved.push_back((*now - *then).norm());
  }
  if (moved.empty()) return std::nullopt;
  const auto middle = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 2);
  std::ranges::nth_element(moved, middle);
  return *middle / elapsed_s;
}

}  // namespace nadir::app
