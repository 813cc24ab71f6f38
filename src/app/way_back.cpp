// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "way_back.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nadir::app {
namespace {

Rigid3 corrected(const DeadReckoned& reckoned, const Corrections& corrections) {
  return corrections.at(reckoned.submap, reckoned.image) * reckoned.survey_from_camera;
}

}  // namespace

void WayBack::observe(const Orientation& orientation, const wire::LiveImage* live) {
  const Shot* shot = orientation.shot.get();
  if (!shot) return;
  for (const ImagePose& pose : orientation.poses) {
    if (view_pose_ && pose.image == view_pose_->image) view_pose_ = pose;  // adjusted
  }
  const auto own = std::ranges::find(orientation.poses, shot->image, &ImagePose::image);
  if (live && own != orientation.poses.end() && own->tie_points >= enough_tie_points_) {
    view_ = {live->image, live->time, live->jpeg};
    view_pose_ = *own;
  }
  const bool lost = orientation.state == TrackingState::lost;
  if (lost && !lost_) untold_ = true;
  lost_ = lost;
  reckoned_ = orientation.dead_reckoned;
}

std::optional<wire::LastView> WayBack::take_last_view() {
  if (!std::exchange(untold_, false)) return std::nullopt;
  return view_;
}

wire::WayBack WayBack::way(const Corrections& corrections, double near) const {
  wire::WayBack way{.lost = lost_};
  if (!lost_ || !reckoned_ || !view_pose_) return way;
  const Rigid3 here = corrected(*reckoned_, corrections);
  const Similarity3 correction = corrections.at(view_pose_->submap, view_pose_->image);
  Eigen::Vector3d to_view =
      correction * view_pose_->survey_from_camera.translation - here.translation;
  to_view.z() = 0;  // over ground
  const Eigen::Vector3d in_camera = here.rotation.conjugate() * to_view;
  way.turn = std::atan2(in_camera.x(), -in_camera.y());
  way.distance = to_view.norm();
  way.sigma = reckoned_->sigma_position * corrections.at(reckoned_->submap, reckoned_->image).scale;
  way.known = way.sigma <= std::max(way.distance, near);
  return way;
}

std::optional<Eigen::Vector2d> WayBack::reckoned(const Corrections& corrections) const {
  if (!reckoned_) return std::nullopt;
  return corrected(*reckoned_, corrections).translation.head<2>();
}

}  // namespace nadir::app
