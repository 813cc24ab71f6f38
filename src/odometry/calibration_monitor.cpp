// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/calibration_monitor.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "nadir/odometry/self_calibration.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kColumns = 6, kRows = 4;

// By the ray as a pinhole camera has it: near enough, and no lens has to be inverted.
std::size_t cell_of(const CameraModel& camera, const Vector2d& ray) {
  const auto index = [](double at, std::size_t cells) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, 0.999) * static_cast<double>(cells));
  };
  return index((ray.y() * camera.fy + camera.cy) / camera.height, kRows) * kColumns +
         index((ray.x() * camera.fx + camera.cx) / camera.width, kColumns);
}

// The residuals of one key frame in its left image, or in its right one.
void add_residuals(const SettledKeyFrame& key_frame, bool in_right, ResidualVariance& variance) {
  struct Cell {
    Vector2d sum = Vector2d::Zero();
    int count = 0;
  };
  std::array<Cell, kColumns * kRows> cells{};
  const CameraRig& rig = *key_frame.rig;
  const CameraModel& camera = in_right ? rig.right->camera : rig.left;
  Rigid3 camera_from_survey = key_frame.pose.survey_from_camera.inverse();
  if (in_right) camera_from_survey = rig.right->right_from_left * camera_from_survey;
  double total = 0, between = 0;
  for (const TiePointObservation& seen : key_frame.observations) {
    if (in_right && !seen.right_ray) continue;
    const Vector2d& ray = in_right ? *seen.right_ray : seen.ray;
    const auto again = ray_of(camera_from_survey * seen.x_in_survey);
    if (!again) continue;
    const Vector2d residual_px = (*again - ray).cwiseProduct(Vector2d(camera.fx, camera.fy));
    Cell& cell = cells[cell_of(camera, ray)];
    cell.sum += residual_px;
    ++cell.count;
    total += residual_px.squaredNorm();
    variance.within_freedom += 2;
  }
  for (const Cell& cell : cells) {
    if (cell.count == 0) continue;
    between += cell.sum.squaredNorm() / cell.count;
    variance.between_freedom += 2;
    variance.within_freedom -= 2;
  }
  variance.between += between;
  variance.within += total - between;
}

// From key frame to key frame: a lens can change in a dive.
void fade(ResidualVariance& variance) {
  constexpr double kKept = 0.95;
  variance.between *= kKept;
  variance.within *= kKept;
  variance.between_freedom *= kKept;
  variance.within_freedom *= kKept;
}

// So many tie points that an adjustment takes about a second of a desktop processor, and a few of a
// small one: each keeps all its rays or none.
CalibrationMonitor::KeyFrames thinned(const CalibrationMonitor::KeyFrames& key_frames) {
  constexpr std::size_t kMostRays = 6000;
  std::size_t rays = 0;
  for (const auto& key_frame : key_frames) {
    for (const auto& seen : key_frame->observations) rays += seen.right_ray ? 2 : 1;
  }
  const std::size_t every = 1 + rays / kMostRays;
  CalibrationMonitor::KeyFrames result;
  for (const auto& key_frame : key_frames) {
    auto thin = std::make_shared<SettledKeyFrame>();
    thin->pose = key_frame->pose;
    thin->rig = key_frame->rig;
    std::ranges::copy_if(key_frame->observations, std::back_inserter(thin->observations),
                         [&](const auto& seen) { return seen.tie_point % every == 0; });
    result.push_back(std::move(thin));
  }
  return result;
}

}  // namespace

double ResidualVariance::ratio() const {
  if (!(within > 0 && within_freedom > 0)) return 0;
  return between / between_freedom * (within_freedom / within);
}

void CalibrationMonitor::add(const std::shared_ptr<const SettledKeyFrame>& key_frame) {
  constexpr std::size_t kMostKeyFrames = 16;
  if (!recent_.empty() && recent_.back()->pose.submap != key_frame->pose.submap) {
    recent_.clear();
    variance_ = {};
  }
  if (recent_.size() == kMostKeyFrames) recent_.erase(recent_.begin());
  recent_.push_back(key_frame);
  fade(variance_);
  add_residuals(*key_frame, false, variance_);
  if (key_frame->rig->right) add_residuals(*key_frame, true, variance_);
  ++key_frames_;
}

bool CalibrationMonitor::is_due(bool last) const {
  constexpr std::size_t kFewestKeyFrames = 8;
  constexpr int kMostAttempts = 3;
  // Settled key frames of rendered surveys with a calibration that fits have 0.8 to 1.6, at
  // residuals of 0.07 to 0.2 px; with one that is plainly wrong 4.6 to 27, at 0.1 to 0.35 px.
  constexpr double kAlike = 2.5;
  if (recent_.size() < kFewestKeyFrames || variance_.ratio() <= kAlike) return false;
  if (last) return key_frames_ > fitted_at_;
  return attempts_ < kMostAttempts && key_frames_ >= 2 * fitted_at_;
}

std::vector<Alert> CalibrationMonitor::observe(const KeyFrames& settled, bool last) {
  if (alerted_) return {};
  for (const auto& key_frame : settled) add(key_frame);
  if (!is_due(last)) return {};
  fitted_at_ = key_frames_;
  const auto fit = fit_calibration(thinned(recent_));
  if (!fit) return {};  // too few tie points
  ++attempts_;
  std::vector<Alert> alerts = doubts(*fit);
  for (Alert& doubt : alerts) {
    doubt.time = recent_.back()->pose.time;
    doubt.image = recent_.back()->pose.image;
  }
  alerted_ = !alerts.empty();
  if (alerted_) recent_.clear();
  return alerts;
}

}  // namespace nadir::odometry
