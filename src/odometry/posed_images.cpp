// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/posed_images.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "health.hpp"
#include "mapping.hpp"
#include "motion.hpp"
#include "nadir/core/check.hpp"
#include "posed_mapping.hpp"
#include "stereo_check.hpp"
#include "window.hpp"

namespace nadir::odometry {
namespace {

constexpr std::size_t kConnected = 15;  // tie points that make two images neighbours
constexpr std::size_t kMinPoints = 50;  // of a window worth placing a map by, as in odometry
constexpr int kHosts = 2;               // earlier key frames tried where nothing is tracked

ImagePose own_pose(const Frame& frame, const Resection& here) {
  return {frame.image, frame.time,
          0,           here.camera_from_map.inverse(),
          false,       static_cast<std::uint32_t>(here.seen.size()),
          here.rms_px};
}

// The frame as of a single camera: a pair's baseline is judged here, not where it is placed.
std::shared_ptr<const Frame> left_alone(Frame frame) {
  frame.right = cv::Mat();
  return std::make_shared<const Frame>(std::move(frame));
}

Alert no_pose_alert(const Frame& frame, const std::string& origin) {
  return {frame.time, frame.image, AlertKind::tracking_lost,
          "image " + std::to_string(frame.image) + ": has no pose in " + origin,
          "orient it with the program that made the poses, or replay without them"};
}

Alert misfit_alert(const Frame& frame, const Connection& found, std::size_t matches) {
  return {frame.time, frame.image, AlertKind::calibration_suspect,
          "image " + std::to_string(frame.image) + ": only " + std::to_string(found.agreeing) +
              " of " + std::to_string(matches) +
              " matches with the image before agree with the given poses",
          "check that poses, images and calibration belong together"};
}

Alert scale_alert(const Frame& frame, double metres) {
  const auto percent = std::to_string(std::lround(std::abs(1 - 1 / metres) * 100));
  return {frame.time, frame.image, AlertKind::scale_conflict,
          "the given poses are " + percent + " % too " + (metres < 1 ? "large" : "small") +
              " for the baseline of the pair; they are kept",
          "check the unit of the poses and the baseline in the calibration"};
}

}  // namespace

struct PosedImages::State {
  Config config;
  GivenPoses poses;
  Placement placement;
  TrackingState tracking = TrackingState::waiting;

  StereoCheck stereo_check;
  Map map;                        ///< by the left cameras; in the given frame until placed
  Similarity3 survey_from_given;  ///< once placed
  bool placed = false;
  std::vector<ImagePose> waiting;  ///< to be placed
  int connected = 0;               ///< last key frames that share ground from each to the next
  /// The last key frame shares none with those before, which were so many. It has no tie points.
  std::optional<int> connected_before;
  std::optional<std::uint64_t> last_central;
  bool lost_told = false, misfit_told = false, scale_checked = false;

  void process(const std::shared_ptr<const View>& view, Orientation& out);
  void lose(const Frame& frame, Orientation& out);
  bool brings_new_ground(const View& view, const Resection& here) const;
  void add(const std::shared_ptr<const View>& view, const Resection& here, Orientation& out);
  void connect_untracked(const View& view, Orientation& out);
  void drop_alone(std::size_t index);
  void set_alone();
  void place(int images, const AdjustmentSummary& summary);
  void check_scale(int images, Orientation& out);
  void publish(const ImagePose& pose, Orientation& out);
  void publish_key_frames(int images, Orientation& out);
  void publish_window(int images, const AdjustmentSummary& summary, Orientation& out);
};

void PosedImages::State::process(const std::shared_ptr<const View>& view, Orientation& out) {
  const Frame& frame = *view->frame;
  const bool given =
      frame.image < poses.map_from_camera.size() && poses.map_from_camera[frame.image];
  if (!given) return lose(frame, out);
  tracking = placed ? TrackingState::tracking : TrackingState::initialising;
  if (std::exchange(lost_told, false)) {
    out.alerts.push_back({frame.time, frame.image, AlertKind::tracking_recovered,
                          "images have given poses again", "none needed"});
  }
  if (!map.rig) {
    CameraRig left = *frame.rig;
    left.right.reset();
    map.rig = std::make_shared<const CameraRig>(left);
  }
  const Rigid3 pose = (survey_from_given * *poses.map_from_camera[frame.image]).inverse();
  const bool blank = is_blank(*view);
  const Resection here = blank ? Resection{pose, {}, 0, 0} : measure_at(map, *view, pose, config);
  // Of what follows a key frame that has no tie points yet, none are expected.
  if (blank || here.expected > 0) count(out.health, map, here, config);
  if (blank) return publish(own_pose(frame, here), out);
  if (brings_new_ground(*view, here)) return add(view, here, out);
  publish(own_pose(frame, here), out);
}

void PosedImages::State::lose(const Frame& frame, Orientation& out) {
  tracking = TrackingState::lost;
  out.lost.push_back(frame.image);
  if (!std::exchange(lost_told, true)) out.alerts.push_back(no_pose_alert(frame, poses.origin));
}

// As in odometry; where too little is tracked, corners tell how far the image went.
bool PosedImages::State::brings_new_ground(const View& view, const Resection& here) const {
  if (map.key_frames.empty()) return true;
  const double far = config.key_frame_shift * std::min(view.camera().width, view.camera().height);
  if (here.seen.size() >= kConnected) {
    return shift_since_last(map, here) > far ||
           static_cast<int>(here.seen.size()) < config.tie_points / 4;
  }
  const auto matched = correspond(map.last().features, view.features, view.camera());
  return matched.pairs.size() < kConnected || matched.shift_px > far;
}

void PosedImages::State::add(const std::shared_ptr<const View>& view, const Resection& here,
                             Orientation& out) {
  if (connected_before && here.seen.size() >= kConnected) {
    drop_alone(map.key_frames.size() - 1);
    connected = *std::exchange(connected_before, std::nullopt);
  }
  add_key_frame(map, view, here);
  if (here.seen.size() < kConnected) connect_untracked(*view, out);
  add_tie_points(map, config);
  const auto all = static_cast<int>(map.key_frames.size());
  const AdjustmentSummary summary = adjust_window(map, config.window, all, config);
  if (map.last().points.size() < kConnected) {
    set_alone();
    count(out.health, map, {here.camera_from_map, {}, 0, 0}, config);  // until the next shares any
    publish(own_pose(*view->frame, here), out);
    retire(map, config);
    return;
  }
  connected_before.reset();
  ++connected;
  const int images = std::min(connected, config.window);
  constexpr int kFewest = 3;  // images of a window whose plane can be told
  const bool whole = images >= kFewest;
  if (!placed && whole) place(images, summary);
  publish_key_frames(images, out);
  // Before, the first two had no tie points yet, and one that corners connect only those tracked.
  constexpr int kFirstPair = 2;
  const bool tracked = here.seen.size() >= kConnected;
  const int told = connected == kFirstPair ? kFirstPair : tracked ? 0 : 1;
  for (int k = all - told; k < all; ++k) tell_health(map, k, config, out);
  if (placed && whole) {
    check_scale(images, out);
    publish_window(images, summary, out);
  }
  retire(map, config);
}

void PosedImages::State::connect_untracked(const View& view, Orientation& out) {
  const int last = static_cast<int>(map.key_frames.size()) - 1;
  for (int host = last - 1; host >= std::max(0, last - kHosts); --host) {
    if (!map.key_frame(host).view) break;
    const auto matched = correspond(map.key_frame(host).features, view.features, view.camera());
    const Connection found = connect(map, host, matched, config);
    const std::size_t matches = matched.pairs.size();
    constexpr double kMisfit = 0.3;
    const bool misfit =
        matches >= kMinPoints && found.agreeing < kMisfit * static_cast<double>(matches);
    if (misfit && !std::exchange(misfit_told, true)) {
      out.alerts.push_back(misfit_alert(*view.frame, found, matches));
    }
  }
}

// It has no tie points, and those after it none either.
void PosedImages::State::drop_alone(std::size_t index) {
  map.key_frames.erase(map.key_frames.begin() + static_cast<std::ptrdiff_t>(index));
}

// The image begins a piece of ground of its own, or shows none: the next one tells.
void PosedImages::State::set_alone() {
  const int last = static_cast<int>(map.key_frames.size()) - 1;
  const std::vector<int> points = map.last().points;
  for (const int point : points) {
    if (map.point(point).sightings.size() > 2)
      give_up_sighting(map, point, last);
    else
      give_up(map, point);
  }
  if (connected_before)
    drop_alone(map.key_frames.size() - 2);
  else
    connected_before = connected;
  connected = 1;
}

void PosedImages::State::place(int images, const AdjustmentSummary& summary) {
  const Window initial = make_window(map, images, summary);
  if (initial.tie_points.size() < kMinPoints) return;
  std::vector<std::shared_ptr<const Frame>> frames;
  for (auto k = map.key_frames.end() - images; k != map.key_frames.end(); ++k) {
    frames.push_back(left_alone(*k->view->frame));
  }
  SubmapPlacement there = placement(initial, frames);
  double& scale = there.survey_from_odometry.scale;
  const double chosen = scale;
  if (poses.is_metric) {
    scale = 1;
    there.scale = {ScaleSource::poses, 0};
  } else if (const auto pair = pair_scale(map, images)) {
    scale = pair->metres;
    there.scale = {ScaleSource::stereo, pair->sigma};
  }
  there.survey_from_odometry.rigid.translation *= scale / chosen;
  survey_from_given = there.survey_from_odometry;
  move(map, survey_from_given);
  map.scale = there.scale;
  map.axes = there.axes;
  for (ImagePose& pose : waiting) {
    pose.survey_from_camera = survey_from_given * pose.survey_from_camera;
  }
  placed = true;
  tracking = TrackingState::tracking;
}

void PosedImages::State::check_scale(int images, Orientation& out) {
  constexpr double kConflict = 0.03;  // more than a calibration in air or of another day is off
  if (!poses.is_metric || scale_checked) return;
  const auto pair = pair_scale(map, images);
  if (!pair) return;
  scale_checked = true;
  if (std::abs(pair->metres - 1) > kConflict + 3 * pair->sigma) {
    out.alerts.push_back(scale_alert(*map.last().view->frame, pair->metres));
  }
}

void PosedImages::State::publish(const ImagePose& pose, Orientation& out) {
  (placed ? out.poses : waiting).push_back(pose);
}

void PosedImages::State::publish_key_frames(int images, Orientation& out) {
  const auto first = map.key_frames.end() - images;
  for (auto k = first; k != map.key_frames.end(); ++k) k->rms_px = rms_px(map, *k);
  std::erase_if(waiting, [&](const ImagePose& pose) {
    return std::any_of(first, map.key_frames.end(),
                       [&](const KeyFrame& k) { return k.image == pose.image; });
  });
  for (auto k = first; k != map.key_frames.end(); ++k) publish(pose_of(map, *k), out);
  if (!placed) return;
  out.poses.insert(out.poses.end(), waiting.begin(), waiting.end());
  waiting.clear();
}

void PosedImages::State::publish_window(int images, const AdjustmentSummary& summary,
                                        Orientation& out) {
  Window window = make_window(map, images, summary);
  const std::uint64_t central = window.central->image;
  if (std::exchange(last_central, central) == central) return;  // while a window grows
  for (const int point : std::exchange(map.given_up, {})) {
    window.given_up.push_back(static_cast<std::uint64_t>(point));
  }
  out.window = std::make_shared<const Window>(std::move(window));
}

PosedImages::PosedImages(Config config, GivenPoses poses, Placement placement)
    : state_(std::make_unique<State>()) {
  config.check();
  NADIR_CHECK(placement != nullptr);
  state_->config = config;
  state_->placement = std::move(placement);
  state_->placed = poses.is_survey;
  if (poses.is_survey) {
    state_->map.axes = SurveyAxes::poses;
    state_->map.scale.source = poses.is_metric ? ScaleSource::poses : ScaleSource::none;
  }
  state_->poses = std::move(poses);
}
PosedImages::PosedImages(PosedImages&&) noexcept = default;
PosedImages& PosedImages::operator=(PosedImages&&) noexcept = default;
PosedImages::~PosedImages() = default;

Orientation PosedImages::process(std::shared_ptr<const Shot> shot) {
  Orientation out;
  out.shot = std::move(shot);
  if (out.shot->frame) {
    const auto view = prepare_view(out.shot->frame, state_->config.features);
    view->frame = state_->stereo_check.passed(*view, out.alerts);
    out.health = health_of(*view, state_->config);
    state_->process(view, out);
  }
  out.state = state_->tracking;
  return out;
}

Orientation PosedImages::finish() {
  Orientation out;
  for (const ImagePose& pose : state_->waiting) out.lost.push_back(pose.image);
  if (!out.lost.empty()) {
    const ImagePose& last = state_->waiting.back();
    out.alerts.push_back({last.time, last.image, AlertKind::tracking_lost,
                          "no tie points were found with the poses in " + state_->poses.origin +
                              ", which cannot be placed without",
                          "check that poses, images and calibration belong together"});
    state_->waiting.clear();
  }
  out.state = state_->tracking;
  return out;
}

}  // namespace nadir::odometry
