// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "gauges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "image_check.hpp"

namespace nadir::app {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using wire::Quantity;

constexpr std::size_t kPoses = 64;      // kept; some seconds of a camera at 10 Hz
constexpr double kSmoothing = 0.9;      // s, less than a second between images that jitter
constexpr double kLongestBetween = 10;  // s between two images of one motion

// Without a range of altitudes given: that in which an image shows between two thirds of and one
// and a half times its usual width, and with lanes a tenth more than the lane.
constexpr double kUsual = 1.5, kBeside = 0.9;

coverage::Polygon view_of(const CameraModel& camera) {
  coverage::Polygon view;
  const double right = camera.width - 0.5, bottom = camera.height - 0.5;
  for (const Vector2d& corner :
       {Vector2d(-0.5, -0.5), {right, -0.5}, {right, bottom}, {-0.5, bottom}}) {
    if (const auto ray = camera.unproject(corner)) view.push_back(*ray);
  }
  if (view.size() < 4) view.clear();  // beyond the lens model
  return view;
}

double width_of(const coverage::Polygon& view) {
  return 0.5 * ((view[1] - view[0]).norm() + (view[2] - view[3]).norm());
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

Gauges::Gauges(const Config& config)
    : config_(config.guide),
      weak_(config.odometry),
      max_blur_px_(config.capture.max_blur_px),
      divisor_(config.capture.divisor()) {}

void Gauges::observe(const Orientation& orientation) {
  speed_px_ = image_speed_.observe(orientation);
  if (orientation.window) window_ = orientation.window;
  for (const ImagePose& pose : orientation.poses) poses_[pose.image] = pose;
  while (poses_.size() > kPoses) poses_.erase(poses_.begin());
  const Shot* shot = orientation.shot.get();
  if (!shot) return;
  image_ = shot->image;
  time_ = shot->time;
  health_ = orientation.health;
  attitude_ = shot->frame ? shot->frame->attitude : std::nullopt;
  depth_ = shot->frame ? shot->frame->depth : std::nullopt;
  // A recorded dive has no camera.
  if (!shot->frame || !shot->frame->rig || shot->frame->rig == rig_) return;
  rig_ = shot->frame->rig;
  view_ = view_of(rig_->left);
}

// A dial must not show what was.
bool Gauges::is_tracked() const {
  return newest() && window_ && image_ && newest()->image == *image_ &&
         window_->submap == newest()->submap;
}

const ImagePose* Gauges::before_newest() const {
  if (poses_.size() < 2) return nullptr;
  const ImagePose& before = std::next(poses_.rbegin())->second;
  const bool one_motion = before.submap == newest()->submap && newest()->time > before.time &&
                          seconds(newest()->time - before.time) <= kLongestBetween;
  return one_motion ? &before : nullptr;
}

std::optional<double> Gauges::depth_in_view() const {
  if (!rig_) return std::nullopt;
  const Rigid3 camera_from_survey = newest()->survey_from_camera.inverse();
  const CameraModel& camera = rig_->left;
  std::vector<double> depths;
  for (const TiePoint& point : window_->tie_points) {
    const Vector3d x_in_camera = camera_from_survey * point.x_in_survey;
    const auto pixel = camera.project(x_in_camera);
    if (pixel && pixel->x() > -0.5 && pixel->y() > -0.5 && pixel->x() < camera.width - 0.5 &&
        pixel->y() < camera.height - 0.5)
      depths.push_back(x_in_camera.z());
  }
  return depths.empty() ? std::nullopt : std::optional(median(depths));
}

double Gauges::overlap(const Rigid3& newest_from_before, double depth) const {
  coverage::Polygon before;
  for (const Vector2d& ray : view_) {
    const Vector3d direction = newest_from_before.rotation * ray.homogeneous();
    const Vector3d& from = newest_from_before.translation;
    const double along = (depth - from.z()) / direction.z();
    if (!(along > 0)) return 0;
    before.push_back((from + along * direction).head<2>() / depth);
  }
  return coverage::area(coverage::clipped(view_, before)) / coverage::area(view_);
}

std::optional<Vector3d> Gauges::velocity() const {
  if (!is_tracked()) return std::nullopt;
  const ImagePose* since = before_newest();
  if (!since) return std::nullopt;
  for (auto pose = std::next(poses_.rbegin()); pose != poses_.rend(); ++pose) {
    const double elapsed = seconds(newest()->time - pose->second.time);
    if (pose->second.submap != newest()->submap || elapsed > kLongestBetween) break;
    since = &pose->second;
    if (elapsed >= kSmoothing) break;
  }
  return (newest()->survey_from_camera.translation - since->survey_from_camera.translation) /
         seconds(newest()->time - since->time);
}

// Between images, the median of late.
std::optional<double> Gauges::period_s() const {
  constexpr std::size_t kImages = 10;
  std::vector<double> periods;
  for (auto pose = poses_.rbegin(); periods.size() < kImages; ++pose) {
    const auto before = std::next(pose);
    if (pose == poses_.rend() || before == poses_.rend()) break;
    const double period = seconds(pose->second.time - before->second.time);
    if (period > 0 && period <= kLongestBetween) periods.push_back(period);
  }
  return periods.empty() ? std::nullopt : std::optional(median(periods));
}

// At this speed, in the direction of now, the overlap would be the least wanted.
std::optional<double> Gauges::fastest(double depth) const {
  const ImagePose* before = before_newest();
  const auto period = period_s();
  if (!before || !period) return std::nullopt;
  Vector3d way = (newest()->survey_from_camera.inverse() * before->survey_from_camera).translation;
  way.z() = 0;
  if (!(way.norm() > 1e-6 * depth)) way = Vector3d::UnitY();
  way.normalize();
  double enough = 0, too_far = 0;
  for (const Vector2d& corner : view_) too_far = std::max(too_far, 2 * depth * corner.norm());
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (enough + too_far);
    const Rigid3 moved{Eigen::Quaterniond::Identity(), middle * way};
    (overlap(moved, depth) >= config_.overlap_low ? enough : too_far) = middle;
  }
  return enough / *period;
}

// size: survey units as corrected, of one as odometry left it.
Gauges::Limited Gauges::limited_altitude(double altitude, double size, const Limits& limits) const {
  Limited measure{Quantity::altitude, altitude, {}, {}};
  const bool by_metres = limits.metric && (config_.altitude_low > 0 || config_.altitude_high > 0);
  if (by_metres) {
    if (config_.altitude_low > 0) measure.low = config_.altitude_low;
    if (config_.altitude_high > 0) measure.high = config_.altitude_high;
  } else if (limits.usual_width > 0 && !view_.empty()) {
    const double usual = limits.usual_width * size, width_at_1 = width_of(view_);
    const double narrowest = std::max(usual / kUsual, limits.lane_spacing / kBeside);
    measure.low = narrowest / width_at_1;
    measure.high = std::max(kUsual * usual, narrowest) / width_at_1;
  }
  return measure;
}

void Gauges::add_motion(const Corrections& corrections, const Limits& limits,
                        wire::Measures& measures) const {
  if (!is_tracked()) return;
  const double size = corrections.at(newest()->submap, newest()->image).scale;
  const auto depth = depth_in_view();
  const bool sees = depth && !view_.empty();
  if (depth) measures.measures.push_back(limited_altitude(*depth * size, size, limits));
  if (const auto moving = velocity()) {
    Limited speed{Quantity::speed, moving->head<2>().norm() * size, {}, {}};
    if (const auto most = sees ? fastest(*depth) : std::nullopt) speed.high = *most * size;
    measures.measures.push_back(speed);
  }
  if (const ImagePose* before = before_newest(); before && sees) {
    const Rigid3 newest_from_before =
        newest()->survey_from_camera.inverse() * before->survey_from_camera;
    measures.measures.push_back(
        {Quantity::overlap, overlap(newest_from_before, *depth), config_.overlap_low, {}});
  }
}

void Gauges::add_picture(const Board& board, wire::Measures& measures) const {
  if (!rig_) return;
  const double smeared = speed_px_ && board.exposure_ms
                             ? motion_blur_px(*speed_px_ * divisor_, *board.exposure_ms)
                             : 0;
  const double blur = std::max(smeared, blur_px(health_, weak_.weak_sharpness));
  measures.measures.push_back({Quantity::blur, blur, {}, max_blur_px_});
  constexpr double kWhite = 255;
  measures.measures.push_back({Quantity::brightness, health_.exposure / kWhite,
                               weak_.weak_dark / kWhite, weak_.weak_bright / kWhite});
}

wire::Measures Gauges::measures(const Corrections& corrections, const Board& board,
                                const Limits& limits) const {
  wire::Measures all;
  add_motion(corrections, limits, all);
  add_picture(board, all);
  const auto add = [&](Quantity quantity, const std::optional<double>& value,
                       const std::optional<double>& low = {},
                       const std::optional<double>& high = {}) {
    if (value) all.measures.push_back({quantity, *value, low, high});
  };
  add(Quantity::depth, depth_);
  if (attitude_) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const double heading = std::remainder(attitude_->yaw + limits.convergence, kTurn);
    add(Quantity::heading, heading < 0 ? heading + kTurn : heading);
  }
  constexpr double kLowBattery = 0.3, kLittleSpace = 1e9, kLittleTime = 600, kHot = 80;
  add(Quantity::battery, board.battery, kLowBattery);
  add(Quantity::free_space, board.free_bytes, kLittleSpace);
  add(Quantity::recording_left, board.recording_left_s, kLittleTime);
  add(Quantity::temperature, board.temperature_deg, {}, kHot);
  if (board.utc_offset && image_) add(Quantity::utc, seconds(time_ + *board.utc_offset));
  return all;
}

}  // namespace nadir::app
