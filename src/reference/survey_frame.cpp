// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/survey_frame.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
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

constexpr double kDegree = std::numbers::pi / 180;

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

constexpr const char* kAttitudeRemedy =
    "check ahrs.csv (degrees, not radians; columns seconds, roll, pitch, yaw; signs; clock), "
    "capture.mounting_*_deg and the camera's calibration";
constexpr const char* kWithoutAttitude =
    "The AHRS is left out from here on; up and north of the map, if by it, are not to be relied on";
constexpr const char* kWithoutNorth =
    "Its roll and pitch stay in use; north and the headings of the map are in doubt";

bool is_stereo(const std::vector<std::shared_ptr<const Frame>>& frames) {
  return std::all_of(frames.begin(), frames.end(),
                     [](const auto& frame) { return frame->rig->right && !frame->right.empty(); });
}

// One disparity d = f b / Z has relative sigma s / d; the scale is the mean of all.
double stereo_sigma(const Frame& frame, const Window& window, double matching_px) {
  const double baseline = frame.rig->right->right_from_left.translation.norm();
  const double distance = viewing_distance(window).value_or(1.0);
  const double disparity_px = frame.rig->left.fx * baseline / distance;
  const auto points = static_cast<double>(std::max<std::size_t>(1, window.tie_points.size()));
  return std::hypot(matching_px / std::sqrt(points), kSharedMatching_px) / disparity_px;
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
  (void)parse_origin(origin);
}

SurveyFrame::SurveyFrame(Config config, PlaneOf plane_of,
                         const std::optional<calibration::Lasers>& lasers,
                         const AttitudeSigma& attitude_sigma)
    : config_(std::move(config)),
      plane_of_(std::move(plane_of)),
      claims_(config_.altimeter_below_camera_m, parse_known_length(config_.known_length),
              lasers && fault_of(*lasers).empty() ? lasers : std::nullopt),
      attitude_check_(attitude_sigma) {
  if (const auto origin = parse_origin(config_.origin)) grid_.emplace(*origin);
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
}

std::shared_ptr<const Shot> SurveyFrame::mark(std::shared_ptr<const Shot> shot) {
  const bool has_attitude = shot->frame && shot->frame->attitude;
  const bool unlevel = attitude_fails_ && has_attitude;
  const bool turned = grid_ && has_attitude;
  if (!beams_ && !lasers_alert_ && !unlevel && !turned) return shot;
  Shot marked = *shot;
  if (lasers_alert_) {
    lasers_alert_->time = shot->time;
    lasers_alert_->image = shot->image;
    marked.alerts.push_back(*std::exchange(lasers_alert_, std::nullopt));
  }
  const auto dots = beams_ && shot->frame ? find_laser_dots(*shot->frame, *beams_) : std::nullopt;
  if (unlevel || turned || dots) {
    Frame frame = *shot->frame;
    if (turned) frame.attitude->yaw -= grid_->convergence();
    if (unlevel) frame.attitude.reset();
    if (dots) {
      claims_.observe(*dots);
      for (const LaserDot& dot : dots->dots) frame.hidden.push_back({dot.pixel, dot.radius_px});
      frame.ranges = ranges_of(*dots, *beams_, frame.rig->left);
    }
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
  const auto laser = claims_.by_lasers(initial);
  if (is_stereo(frames)) {
    placement.scale = {ScaleSource::stereo,
                       stereo_sigma(*frames.front(), initial, config_.stereo_matching_px)};
  } else if (laser) {
    placement.scale = {ScaleSource::laser, laser->sigma};
    size = laser->ratio;
  } else {
    size = viewing_distance_ / viewing_distance(initial).value_or(1.0);
  }
  claims_.placed(initial.submap, size, placement.scale);

  Rigid3& rigid = placement.survey_from_odometry.rigid;
  const auto plane = plane_seen_from_above(initial);
  auto leveled =
      config_.attitude && !attitude_fails_ ? from_attitude(initial, frames) : std::nullopt;
  if (first && leveled && is_wall(*leveled, plane, *frames.front())) leveled.reset();
  if (leveled && (first || axes_ == SurveyAxes::attitude)) {
    rigid.rotation = *leveled;
    placement.axes = SurveyAxes::attitude;
  } else {
    rigid.rotation = upright(initial, plane);
    placement.axes = plane ? SurveyAxes::first_plane : SurveyAxes::first_camera;
  }
  if (first) {
    rigid.translation = -(placement.survey_from_odometry * centroid(initial));
    scale_ = placement.scale;
    axes_ = placement.axes;
  } else {
    const Rigid3 camera =
        placement.survey_from_odometry * initial.images.front().survey_from_camera;
    rigid.translation = reckoned_position(*frames.front()) - camera.translation;
  }
  return placement;
}

std::optional<Plane> SurveyFrame::plane_seen_from_above(const Window& initial) const {
  std::optional<Plane> plane = plane_of_(initial);
  if (plane && angle_between(plane->normal, -mean_view_direction(initial)) >
                   config_.max_plane_tilt_deg * kDegree) {
    plane.reset();
  }
  return plane;
}

// A camera mounted to look ahead may well look at one, and a dive may come to one later on.
bool SurveyFrame::is_wall(const Quaterniond& leveled, const std::optional<Plane>& plane,
                          const Frame& first) {
  constexpr double kDownward = 0.7;  // cosine
  constexpr double kSteepest = 60;   // degrees; few reefs are steeper, and no dive starts there
  if (!plane || !((first.rig->body_from_camera * Vector3d::UnitZ()).z() > kDownward)) return false;
  const double slope = angle_between(plane->normal, leveled.conjugate() * Vector3d::UnitZ());
  if (!(slope > kSteepest * kDegree)) return false;
  leave_out_attitude();
  alerts_.push_back(
      {first.time, first.image, AlertKind::calibration_suspect,
       "the AHRS contradicts the images: by its roll and pitch the ground slopes by " +
           std::to_string(std::lround(slope / kDegree)) +
           " degrees, but the camera, mounted to look down, sees it from above",
       kAttitudeRemedy +
           std::string("; if the ground is as steep as that, start above flatter ground. ") +
           kWithoutAttitude});
  return true;
}

void SurveyFrame::leave_out_attitude() {
  attitude_fails_ = true;
  claims_.forget_vertical();
}

// 3.3: z is the normal of the map's plane. A later sub-map also keeps the heading last known.
Eigen::Quaterniond SurveyFrame::upright(const Window& initial,
                                        const std::optional<Plane>& plane) const {
  const Vector3d up = plane ? plane->normal : Vector3d(-mean_view_direction(initial));
  Quaterniond own = axes_of(up, initial.images.front().survey_from_camera.rotation);
  if (!last_) return own;
  const Vector3d x = last_->pose.survey_from_camera.rotation * Vector3d::UnitX();
  return Quaterniond(Eigen::AngleAxisd(std::atan2(x.y(), x.x()), Vector3d::UnitZ())) * own;
}

// From image to image, which no vehicle turns by half a circle.
void SurveyFrame::follow_heading(const Frame& frame) {
  if (!config_.attitude || !last_ || !last_->attitude || !frame.attitude) return;
  if (turns_.empty()) turns_.push_back({last_->pose.time, last_->attitude->yaw, 0});
  const Turn before = turns_.back();
  const double yaw = frame.attitude->yaw;
  const Time end = last_->pose.time + from_seconds(config_.dead_reckoning_max_s);
  if (frame.time <= before.time || before.time >= end) return;
  const double turn = std::remainder(before.yaw - yaw, 2 * std::numbers::pi);
  const double share = static_cast<double>(std::min(frame.time, end) - before.time) /
                       static_cast<double>(frame.time - before.time);
  turns_.push_back({std::min(frame.time, end), yaw, before.turned + share * turn});
}

// 0 when unknown.
double SurveyFrame::turned_by(Time time) const {
  const auto after = std::ranges::upper_bound(turns_, time, {}, &Turn::time);
  return after == turns_.begin() ? 0 : std::prev(after)->turned;
}

// The velocity turns with the vehicle. At a constant rate the way is an arc, whose chord points
// half of the turn aside and is sin(half) / half as long.
Eigen::Vector3d SurveyFrame::reckoned_position(const Frame& frame) const {
  if (!last_) return Vector3d::Zero();
  const double elapsed =
      std::clamp(seconds(frame.time - last_->pose.time), 0.0, config_.dead_reckoning_max_s);
  Vector3d way = last_->velocity * elapsed;
  const double half = 0.5 * turned_by(frame.time);
  if (half != 0) way.head<2>() = std::sin(half) / half * (Eigen::Rotation2Dd(half) * way.head<2>());
  Vector3d position = last_->pose.survey_from_camera.translation + way;
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
    turns_.clear();
  }
  if (orientation.shot && orientation.shot->frame) follow_heading(*orientation.shot->frame);
  check_attitude(orientation);
  tell_unplaced(orientation);
  std::vector<Alert> alerts = std::exchange(alerts_, {});
  if (const Shot* shot = orientation.shot.get()) {
    for (Alert& alert : alerts) {  // of images before it that only now have a pose
      alert.time = shot->time;
      alert.image = shot->image;
    }
  }
  std::ranges::move(claims_.observe(orientation), std::back_inserter(alerts));
  return alerts;
}

// Once, when it is clear or becomes so.
void SurveyFrame::tell_unplaced(const Orientation& orientation) {
  SurveyAxes by = axes();
  if (by == SurveyAxes::none && orientation.window) by = orientation.window->axes;
  if (!grid_ || by == SurveyAxes::none || by == SurveyAxes::attitude) return;
  if (std::exchange(unplaced_is_told_, true)) return;
  alerts_.push_back(
      {0, std::nullopt, AlertKind::sensor_stale,
       "no AHRS is to be relied on for the map's north: reference.origin cannot place "
       "it on the earth, and its files keep coordinates of their own",
       "for a map in UTM, dive or replay with an AHRS that tells roll, pitch and "
       "heading from the first image on"});
}

// An image may get its pose long after its shot, while a map is being started.
void SurveyFrame::check_attitude(const Orientation& orientation) {
  constexpr std::size_t kWaiting = 64;
  if (!config_.attitude || attitude_fails_) return;
  const Shot* shot = orientation.shot.get();
  if (shot && shot->frame && shot->frame->attitude) {
    const Frame& frame = *shot->frame;
    attitudes_[frame.image] = {frame.time, 0, frame.rig->body_from_camera.conjugate(),
                               frame.attitude->ned_from_body()};
    if (attitudes_.size() > kWaiting) attitudes_.erase(attitudes_.begin());
  }
  std::map<std::uint64_t, AttitudeSample> posed;
  for (const ImagePose& pose : orientation.poses) {
    auto known = attitudes_.extract(pose.image);
    if (known.empty()) continue;
    AttitudeSample& sample = known.mapped();
    sample.submap = pose.submap;
    sample.survey_from_body = pose.survey_from_camera.rotation * sample.survey_from_body;
    posed.insert(std::move(known));
  }
  for (const auto& [image, sample] : posed) {
    const auto contradiction = attitude_check_.observe(sample);
    if (!contradiction) continue;
    attitude_doubtful_ = true;
    if (contradiction->of_tilt) leave_out_attitude();
    alerts_.push_back({sample.time, image, AlertKind::calibration_suspect, contradiction->message,
                       std::string(kAttitudeRemedy) + ". " +
                           (contradiction->of_tilt ? kWithoutAttitude : kWithoutNorth)});
  }
}

}  // namespace nadir::reference
