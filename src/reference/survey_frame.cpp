// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/survey_frame.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "ground.hpp"
#include "nadir/core/check.hpp"

namespace nadir::reference {
namespace {

using Eigen::Quaterniond, Eigen::Vector3d;

const Quaterniond kEnuFromNed{Eigen::Matrix3d{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}};

// Depths along the optical axis of the central camera: what "distance to the seabed" means for a
// downward camera.
std::optional<double> viewing_distance(const Window& window) {
  if (window.tie_points.empty()) return std::nullopt;
  const Rigid3 camera_from_map = window.central_pose().survey_from_camera.inverse();
  std::vector<double> depths;
  for (const TiePoint& point : window.tie_points) {
    depths.push_back((camera_from_map * point.x_in_survey).z());
  }
  const double distance = median(std::move(depths));
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

Vector3d centroid(const Window& window) {
  Vector3d sum = Vector3d::Zero();
  for (const TiePoint& point : window.tie_points) sum += point.x_in_survey;
  return sum / static_cast<double>(std::max<std::size_t>(1, window.tie_points.size()));
}

// The rotation nearest to all of them: largest eigenvector of the sum of q q^T (Markley et al.
// 2007).
Quaterniond mean_rotation(const std::vector<Quaterniond>& rotations) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const Quaterniond& q : rotations) sum += q.coeffs() * q.coeffs().transpose();
  const Eigen::Vector4d best =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(sum).eigenvectors().col(3);
  return Quaterniond(best).normalized();
}

// East-north-up from odometry, from the images that have an attitude.
std::optional<Quaterniond> from_attitude(const Window& initial,
                                         const std::vector<std::shared_ptr<const Frame>>& frames) {
  std::vector<Quaterniond> rotations;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i]->attitude) continue;
    const Quaterniond enu_from_camera =
        kEnuFromNed * frames[i]->attitude->ned_from_body() * frames[i]->rig->body_from_camera;
    rotations.push_back(enu_from_camera *
                        initial.images[i].survey_from_camera.rotation.conjugate());
  }
  if (rotations.empty()) return std::nullopt;
  return mean_rotation(rotations);
}

Vector3d mean_view_direction(const Window& window) {
  Vector3d sum = Vector3d::Zero();
  for (const ImagePose& pose : window.images) {
    sum += pose.survey_from_camera.rotation * Vector3d::UnitZ();
  }
  return sum.normalized();
}

// Axes with z along up and x the camera's x axis projected on the plane; rows are the new axes in
// the old frame.
Quaterniond axes_of(const Vector3d& up, const Quaterniond& map_from_camera) {
  const auto flattened = [&](const Vector3d& v) { return Vector3d(v - up * up.dot(v)); };
  Vector3d x = flattened(map_from_camera * Vector3d::UnitX());
  if (x.norm() < 0.1) x = flattened(map_from_camera * -Vector3d::UnitZ());  // a camera on its side
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), up.cross(x).transpose(), up.transpose();
  return Quaterniond(rotation);
}

// By a pair of cameras or by another program's poses: nothing measured afterwards changes it.
bool is_given(ScaleSource source) {
  return source == ScaleSource::stereo || source == ScaleSource::poses;
}

// Two dots may be mistaken in a few images.
bool is_settled(ScaleSource source, const ScaleMeasure& measure) {
  constexpr std::uint32_t kEnough = 5;
  return source != ScaleSource::laser || measure.images >= kEnough;
}

std::string witness(ScaleSource source) {
  switch (source) {
    case ScaleSource::stereo:
      return "the pair of cameras";
    case ScaleSource::poses:
      return "the given poses";
    case ScaleSource::laser:
      return "the lasers";
    case ScaleSource::typed:
      return "the known length";
    case ScaleSource::altitude:
      return "the altimeter";
    case ScaleSource::depth:
      return "changes of depth";
    default:
      return std::string(to_string(source));
  }
}

std::string to_check(ScaleSource source) {
  switch (source) {
    case ScaleSource::stereo:
      return "the baseline in the calibration";
    case ScaleSource::poses:
      return "the given poses";
    case ScaleSource::laser:
      return "separation_m in lasers.yml";
    case ScaleSource::typed:
      return "reference.known_length";
    case ScaleSource::altitude:
      return "altitude.csv and reference.altimeter_below_camera_m";
    default:
      return "depth.csv";
  }
}

bool is_stereo(const std::vector<std::shared_ptr<const Frame>>& frames) {
  return std::all_of(frames.begin(), frames.end(),
                     [](const auto& frame) { return frame->rig->right && !frame->right.empty(); });
}

// One disparity d = f b / Z has relative sigma s / d; the scale is the mean of all.
double stereo_sigma(const Frame& frame, const Window& window, double matching_px) {
  const double baseline = frame.rig->right->right_from_left.translation.norm();
  const double distance = viewing_distance(window).value_or(1.0);
  const double disparity_px = frame.rig->left.fx * baseline / distance;
  return matching_px / disparity_px /
         std::sqrt(static_cast<double>(std::max<std::size_t>(1, window.tie_points.size())));
}

}  // namespace

void Config::check() const {
  if (!(stereo_matching_px >= 0.001 && stereo_matching_px <= 100)) {
    throw InputError("reference.stereo_matching_px must be 0.001 to 100; the default is 0.3");
  }
  if (!(max_plane_tilt_deg > 0 && max_plane_tilt_deg < 90)) {
    throw InputError("reference.max_plane_tilt_deg must be between 0 and 90; the default is 35");
  }
  if (!(dead_reckoning_max_s >= 0)) {
    throw InputError("reference.dead_reckoning_max_s must be 0 or more; the default is 5");
  }
  if (!(std::abs(altimeter_below_camera_m) <= 10)) {
    throw InputError("reference.altimeter_below_camera_m must be -10 to 10; the default is 0");
  }
  (void)parse_known_length(known_length);
}

SurveyFrame::SurveyFrame(Config config, PlaneOf plane_of,
                         const std::optional<calibration::Lasers>& lasers)
    : config_(std::move(config)),
      plane_of_(std::move(plane_of)),
      sensors_(config_.altimeter_below_camera_m) {
  if (const auto length = parse_known_length(config_.known_length)) typed_.emplace(*length);
  if (!lasers) return;
  if (const std::string fault = fault_of(*lasers); !fault.empty()) {
    lasers_alert_ = Alert{0,
                          {},
                          AlertKind::calibration_suspect,
                          "the lasers give no scale: " + fault,
                          "correct lasers.yml; the map goes on without them"};
    return;
  }
  if (const std::string conflict = conflict_of(*lasers); !conflict.empty()) {
    lasers_alert_ = Alert{0,
                          {},
                          AlertKind::scale_conflict,
                          conflict,
                          "correct lasers.yml; until then separation_m is believed"};
  }
  beams_ = lasers;
  lasers_.emplace(*lasers);
}

std::shared_ptr<const Shot> SurveyFrame::mark(std::shared_ptr<const Shot> shot) {
  if (!beams_ && !lasers_alert_) return shot;
  Shot marked = *shot;
  if (lasers_alert_) {
    lasers_alert_->time = shot->time;
    lasers_alert_->image = shot->image;
    marked.alerts.push_back(*std::exchange(lasers_alert_, std::nullopt));
  }
  const auto dots = beams_ && shot->frame ? find_laser_dots(*shot->frame, *beams_) : std::nullopt;
  if (dots) {
    lasers_->observe(*dots);
    Frame frame = *shot->frame;
    for (const LaserDot& dot : dots->dots) frame.hidden.push_back({dot.pixel, dot.radius_px});
    frame.ranges = ranges_of(*dots, *beams_, frame.rig->left);
    marked.frame = std::make_shared<const Frame>(std::move(frame));
  }
  return std::make_shared<const Shot>(std::move(marked));
}

SubmapPlacement SurveyFrame::place(const Window& initial,
                                   const std::vector<std::shared_ptr<const Frame>>& frames) {
  NADIR_CHECK(!frames.empty() && frames.size() == initial.images.size(), frames.size());
  const bool first = axes_ == SurveyAxes::none;
  SubmapPlacement placement;
  placement.uncertain = !first;

  double& size = placement.survey_from_odometry.scale;
  if (lasers_) lasers_->observe(initial);
  const auto laser = lasers_ ? lasers_->estimate(initial.submap) : std::nullopt;
  if (is_stereo(frames)) {
    placement.scale = {ScaleSource::stereo,
                       stereo_sigma(*frames.front(), initial, config_.stereo_matching_px)};
  } else if (laser) {
    placement.scale = {ScaleSource::laser, laser->sigma};
    size = laser->ratio;
  } else {
    size = viewing_distance_ / viewing_distance(initial).value_or(1.0);
  }
  if (lasers_) lasers_->resized(initial.submap, size);
  told_[initial.submap] = placement.scale;

  Rigid3& rigid = placement.survey_from_odometry.rigid;
  const auto leveled = config_.attitude ? from_attitude(initial, frames) : std::nullopt;
  if (leveled && (first || axes_ == SurveyAxes::attitude)) {
    rigid.rotation = *leveled;
    axes_ = SurveyAxes::attitude;
  } else {
    rigid.rotation = upright(initial);
  }
  if (first) {
    rigid.translation = -(placement.survey_from_odometry * centroid(initial));
    scale_ = placement.scale;
  } else {
    const Rigid3 camera =
        placement.survey_from_odometry * initial.images.front().survey_from_camera;
    rigid.translation = reckoned_position(*frames.front()) - camera.translation;
  }
  placement.axes = axes_;
  return placement;
}

// 3.3: z is the normal of the map's plane. A later sub-map also keeps the heading last known.
Eigen::Quaterniond SurveyFrame::upright(const Window& initial) {
  const Vector3d against_view = -mean_view_direction(initial);
  std::optional<Plane> plane = plane_of_(initial);
  const double tilt = plane ? std::acos(std::min(1.0, plane->normal.dot(against_view))) : 0;
  if (tilt > config_.max_plane_tilt_deg * std::numbers::pi / 180) plane.reset();
  const Vector3d up = plane ? plane->normal : against_view;
  if (axes_ == SurveyAxes::none) {
    axes_ = plane ? SurveyAxes::first_plane : SurveyAxes::first_camera;
  }
  Quaterniond own = axes_of(up, initial.images.front().survey_from_camera.rotation);
  if (!last_) return own;
  const Vector3d x = last_->pose.survey_from_camera.rotation * Vector3d::UnitX();
  return Quaterniond(Eigen::AngleAxisd(std::atan2(x.y(), x.x()), Vector3d::UnitZ())) * own;
}

Eigen::Vector3d SurveyFrame::reckoned_position(const Frame& frame) const {
  if (!last_) return Vector3d::Zero();
  const double elapsed =
      std::clamp(seconds(frame.time - last_->pose.time), 0.0, config_.dead_reckoning_max_s);
  Vector3d position = last_->pose.survey_from_camera.translation + last_->velocity * elapsed;
  if (scale_.source != ScaleSource::none && frame.depth && last_->depth) {
    position.z() = last_->pose.survey_from_camera.translation.z() + *last_->depth - *frame.depth;
  }
  return position;
}

// The change that the AHRS saw, from the last pose.
Eigen::Quaterniond SurveyFrame::reckoned_rotation(const Frame& frame) const {
  const Quaterniond& last = last_->pose.survey_from_camera.rotation;
  if (!config_.attitude || !frame.attitude || !last_->attitude) return last;
  const auto ned_from_camera = [&](const Attitude& attitude) {
    return attitude.ned_from_body() * frame.rig->body_from_camera;
  };
  return (last * ned_from_camera(*last_->attitude).conjugate() * ned_from_camera(*frame.attitude))
      .normalized();
}

std::optional<DeadReckoned> SurveyFrame::dead_reckon(const Orientation& orientation) const {
  const Shot* shot = orientation.shot.get();
  if (!last_ || !shot || !shot->frame) return std::nullopt;
  const auto is_its = [&](const ImagePose& pose) { return pose.image == shot->image; };
  if (std::ranges::any_of(orientation.poses, is_its)) return std::nullopt;
  // How fast a diver or an ROV changes its speed over some seconds; of an unscaled map, whose unit
  // is the distance to the ground, the same is as good as any.
  constexpr double kSpeedChange = 0.2;
  const double speed = last_->velocity.norm();
  const double elapsed = std::max(0.0, seconds(shot->time - last_->pose.time));
  const double unreckoned = std::max(0.0, elapsed - config_.dead_reckoning_max_s);
  const double sigma = std::hypot(kSpeedChange, 0.5 * speed) * elapsed + speed * unreckoned;
  return DeadReckoned{shot->image,
                      last_->pose.submap,
                      {reckoned_rotation(*shot->frame), reckoned_position(*shot->frame)},
                      sigma};
}

std::vector<Alert> SurveyFrame::observe(const Orientation& orientation) {
  if (orientation.window) {
    viewing_distance_ = viewing_distance(*orientation.window).value_or(viewing_distance_);
    const Scale& scale = orientation.window->scale;
    if (is_given(scale.source)) told_[orientation.window->submap] = scale;
  }
  for (const ImagePose& pose : orientation.poses) {
    if (last_ && pose.image <= last_->pose.image) continue;
    LastSeen now{pose, Vector3d::Zero(), std::nullopt, std::nullopt};
    if (orientation.shot && orientation.shot->image == pose.image && orientation.shot->frame) {
      now.depth = orientation.shot->frame->depth;
      now.attitude = orientation.shot->frame->attitude;
    }
    if (last_ && last_->pose.submap == pose.submap && pose.time > last_->pose.time) {
      now.velocity =
          (pose.survey_from_camera.translation - last_->pose.survey_from_camera.translation) /
          seconds(pose.time - last_->pose.time);
    }
    last_ = now;
  }
  sensors_.observe(orientation);
  if (typed_) typed_->observe(orientation);
  if (lasers_) lasers_->observe(orientation);
  return conflicts(orientation);
}

std::vector<SurveyFrame::Claim> SurveyFrame::claims(std::uint32_t submap) const {
  std::vector<Claim> all;
  const auto add = [&](ScaleSource source, const std::optional<ScaleMeasure>& measure) {
    if (measure) all.push_back({source, *measure});
  };
  const auto told = told_.find(submap);
  if (told != told_.end() && is_given(told->second.source)) {
    add(told->second.source, ScaleMeasure{1, told->second.sigma, 1});
  }
  if (typed_) add(ScaleSource::typed, typed_->estimate(submap));
  if (lasers_) add(ScaleSource::laser, lasers_->estimate(submap));
  add(ScaleSource::altitude, sensors_.by_altitude(submap));
  add(ScaleSource::depth, sensors_.by_depth(submap));
  return all;
}

// Of those that measure the map as it is; a given scale is part of it.
std::optional<SurveyFrame::Claim> SurveyFrame::best_claim(std::uint32_t submap) const {
  std::optional<Claim> best;
  for (const Claim& claim : claims(submap)) {
    if (is_given(claim.source)) continue;
    if (!best || claim.measure.sigma < best->measure.sigma) best = claim;
  }
  return best;
}

// Once for each two sources and sub-map.
std::vector<Alert> SurveyFrame::conflicts(const Orientation& orientation) {
  const Shot* shot = orientation.shot.get();
  std::vector<Alert> alerts;
  const auto add = [&](std::string message, std::string remedy) {
    alerts.push_back({shot ? shot->time : 0, shot ? std::optional(shot->image) : std::nullopt,
                      AlertKind::scale_conflict, std::move(message), std::move(remedy)});
  };
  if (!shot && typed_ && !typed_->fault().empty()) {
    add("the known length gives no scale: " + typed_->fault(),
        "correct reference.known_length: the image's number counts from 0");
  }
  if (!orientation.window || !told_.contains(orientation.submap)) return alerts;
  const std::vector<Claim> all = claims(orientation.submap);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (agree(all[i], all[k])) continue;
      const Claim &one = all[i], &other = all[k];
      if (!in_conflict_.insert({orientation.submap, one.source, other.source}).second) continue;
      const double excess = other.measure.ratio / one.measure.ratio - 1;
      const ScaleSource told = told_.at(orientation.submap).source;
      const ScaleSource better =
          one.measure.sigma < other.measure.sigma ? one.source : other.source;
      add("by " + witness(other.source) + " the map is " +
              std::to_string(std::lround(100 * std::abs(excess))) + " % " +
              (excess > 0 ? "larger" : "smaller") + " than by " + witness(one.source),
          "check " + to_check(one.source) + " and " + to_check(other.source) +
              "; the map keeps to " + witness(told == ScaleSource::none ? better : told));
    }
  }
  return alerts;
}

// Those that are not settled contradict nothing.
bool SurveyFrame::agree(const Claim& one, const Claim& other) {
  constexpr double kTolerated = 0.02;  // separations and baselines are measured to a hundredth
  constexpr double kSigmas = 3;
  if (!is_settled(one.source, one.measure) || !is_settled(other.source, other.measure)) return true;
  const double sigma = std::hypot(one.measure.sigma, other.measure.sigma);
  return std::abs(std::log(other.measure.ratio / one.measure.ratio)) <
         std::max(kTolerated, kSigmas * sigma);
}

std::vector<ScaleEstimate> SurveyFrame::improved_scales(const Orientation& orientation) {
  constexpr double kClearly = 0.6;  // of the sigma told before
  std::vector<ScaleEstimate> improved;
  const bool last = !orientation.shot;
  if (!last && !orientation.window) return improved;
  for (auto& [submap, told] : told_) {
    if (is_given(told.source)) continue;
    if (!last && submap != orientation.submap) continue;
    const auto claim = best_claim(submap);
    if (!claim) continue;
    const auto& [ratio, sigma, images] = claim->measure;
    const bool better = told.source == ScaleSource::none || sigma < kClearly * told.sigma;
    if (!better && !last) continue;
    told = {claim->source, sigma};
    improved.push_back({submap, ratio, told});
  }
  return improved;
}

}  // namespace nadir::reference
