// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/visual_odometry.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "health.hpp"
#include "initialisation.hpp"
#include "loss.hpp"
#include "mapping.hpp"
#include "motion.hpp"
#include "nadir/core/check.hpp"
#include "resection.hpp"
#include "stereo_check.hpp"
#include "window.hpp"

namespace nadir::odometry {
namespace {

using Views = std::vector<std::shared_ptr<const View>>;

constexpr std::size_t kFewestStarting = 3;  // key images
constexpr std::size_t kMaxFollowers = 200;  // hovering must not gather them for ever
constexpr std::size_t kMaxWaiting = 32;     // images kept while a map is being started

// An image oriented between two key frames: it follows its key frame when that is adjusted.
struct Follower {
  ImagePose pose;
  int key_frame = 0;
  Rigid3 camera_from_key_frame;
};

void append(Settled& all, Settled more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

// Of an image that is no key frame.
ImagePose pose_of(const Map& map, const Frame& frame, const Resection& resection) {
  const Sigmas sigmas = sigmas_of(map, resection);
  return {frame.image,
          frame.time,
          map.submap,
          resection.camera_from_map.inverse(),
          false,
          static_cast<std::uint32_t>(resection.seen.size()),
          resection.rms_px,
          sigmas.position,
          sigmas.rotation};
}

}  // namespace

/// The state machine of paper 3.2:
///
///   waiting --an image with structure--> initialising --n key images fit--> tracking
///                                             |                               |   ^
///                                        images part                  no pose |   | the map is
///                                             v                               v   | found again,
///                                             or
///                                          waiting                           lost-+ a new one
///                                          starts
struct VisualOdometry::State {
  Config config;
  Placement placement;
  TrackingState tracking = TrackingState::waiting;

  StereoCheck stereo_check;
  std::optional<Map> map;
  std::vector<Follower> followers;
  std::vector<Moment> track;  ///< the last two oriented images
  std::uint32_t next_submap = 0;
  std::uint64_t next_id = 0;
  std::optional<std::uint64_t> last_central;  ///< central image of the last window published

  Views waiting;         ///< images that may still be oriented once a map starts
  Views key_images;      ///< those of them to start it from
  bool alerted = false;  ///< of this loss
  // While the first map is being started:
  bool unfit = false;        ///< key images moved but gave no map
  Time searching_since = 0;  ///< of the first image that showed something
  std::uint64_t searched = 0;
  bool told_no_map = false;

  void process(const std::shared_ptr<const View>& view, Orientation& out);
  void begin_submap();
  void follow(const std::shared_ptr<const View>& view, Orientation& out);
  void lose(const std::shared_ptr<const View>& view, LossReason reason, Orientation& out);
  void recover(const std::shared_ptr<const View>& view, Orientation& out);
  void gather(const std::shared_ptr<const View>& view, Orientation& out);
  void wait(const std::shared_ptr<const View>& view, Orientation& out);
  bool start(Orientation& out);
  bool start_early(Orientation& out);
  std::size_t images_to_start() const;
  void give_up_waiting(Orientation& out);
  void tell_of_no_map(const View& view, Orientation& out);

  void accept(const std::shared_ptr<const View>& view, const Resection& resection,
              Orientation& out);
  void orient_waiting(Orientation& out);
  void publish_window(const AdjustmentSummary& summary, int images, Orientation& out);
  ResectionResult resect_here(const View& view, const std::optional<Rigid3>& predicted,
                              int key_frames, Effort effort);
};

void VisualOdometry::State::process(const std::shared_ptr<const View>& view, Orientation& out) {
  switch (tracking) {
    case TrackingState::waiting:
    case TrackingState::initialising:
      gather(view, out);
      return tell_of_no_map(*view, out);
    case TrackingState::tracking:
      return follow(view, out);
    case TrackingState::lost:
      return recover(view, out);
  }
}

// As at the beginning of a dive: images gather, and none is looked for in the map there is.
void VisualOdometry::State::begin_submap() {
  track.clear();
  tracking = key_images.empty() ? TrackingState::waiting : TrackingState::initialising;
}

// A dive that begins without a map must not look like one that goes well.
void VisualOdometry::State::tell_of_no_map(const View& view, Orientation& out) {
  constexpr Time kPatience = 10'000'000'000;
  constexpr std::uint64_t kFewest = 10;
  if (tracking != TrackingState::initialising) {
    searched = 0;
    return;
  }
  if (searched++ == 0) searching_since = view.frame->time;
  const bool long_since = searched >= kFewest && view.frame->time - searching_since >= kPatience;
  if (!long_since || std::exchange(told_no_map, true)) return;
  out.alerts.push_back(
      no_map_yet_alert(*view.frame, unfit ? StartTrouble::no_fit : StartTrouble::no_motion));
}

void VisualOdometry::State::follow(const std::shared_ptr<const View>& view, Orientation& out) {
  const auto result = resect_here(*view, predict(track, view->frame->time), 3, Effort::thorough);
  if (!result.resection) return lose(view, result.reason, out);
  accept(view, *result.resection, out);
}

void VisualOdometry::State::lose(const std::shared_ptr<const View>& view, LossReason reason,
                                 Orientation& out) {
  tracking = TrackingState::lost;
  track.clear();
  out.alerts.push_back(loss_alert(*view, reason, config));
  alerted = true;
  if (config.on_lost == OnLost::stop) {
    out.lost.push_back(view->frame->image);
    return;
  }
  gather(view, out);
}

void VisualOdometry::State::recover(const std::shared_ptr<const View>& view, Orientation& out) {
  if (config.on_lost == OnLost::stop) {
    out.lost.push_back(view->frame->image);
    return;
  }
  if (map) {
    const auto result =
        resect_here(*view, std::nullopt, config.relocalise_key_frames, Effort::thorough);
    if (result.resection) {
      tracking = TrackingState::tracking;
      out.alerts.push_back({view->frame->time, view->frame->image, AlertKind::tracking_recovered,
                            "the ground seen before was found again", "none needed"});
      accept(view, *result.resection, out);
      orient_waiting(out);
      return;
    }
  }
  gather(view, out);
}

void VisualOdometry::State::gather(const std::shared_ptr<const View>& view, Orientation& out) {
  if (is_blank(*view)) {
    if (start_early(out)) return follow(view, out);
    give_up_waiting(out);
    out.lost.push_back(view->frame->image);
    if (!std::exchange(alerted, true)) {
      out.alerts.push_back(loss_alert(*view, LossReason::blank_image, config));
    }
    return;
  }
  if (tracking == TrackingState::waiting) tracking = TrackingState::initialising;
  if (!key_images.empty()) {
    constexpr std::size_t kMinPairs = 25;
    const auto matched = correspond(key_images.back()->features, view->features, view->camera());
    if (matched.pairs.size() < kMinPairs) {
      if (start_early(out)) return follow(view, out);
      give_up_waiting(out);
      if (!std::exchange(alerted, true)) {
        out.alerts.push_back(loss_alert(*view, reason_without_matches(*view), config));
      }
    } else if (matched.shift_px <
               config.key_frame_shift * std::min(view->camera().width, view->camera().height)) {
      wait(view, out);
      // So many that some would be given up: on with the key images there are.
      if (waiting.size() < kMaxWaiting || key_images.size() < kFewestStarting) return;
      if (!start(out)) key_images.erase(key_images.begin());
      return;
    }
  }
  wait(view, out);
  key_images.push_back(view);
  if (key_images.size() < images_to_start()) return;
  if (start(out)) return;
  key_images.erase(key_images.begin());
}

// Waiting images hold their pixels: beyond so many the oldest that no start needs is given up.
void VisualOdometry::State::wait(const std::shared_ptr<const View>& view, Orientation& out) {
  waiting.push_back(view);
  if (waiting.size() <= kMaxWaiting) return;
  const auto idle = std::find_if(waiting.begin(), waiting.end(), [&](const auto& v) {
    return std::find(key_images.begin(), key_images.end(), v) == key_images.end();
  });
  out.lost.push_back((*idle)->frame->image);
  waiting.erase(idle);
}

bool VisualOdometry::State::start(Orientation& out) {
  auto started = start_map(key_images, config);
  unfit = !started;
  if (unfit) return false;
  if (map) append(out.settled, retire_all(*map));
  map = std::move(started);
  map->submap = next_submap++;
  map->first_id = next_id;
  followers.clear();
  const int images = static_cast<int>(key_images.size());
  AdjustmentSummary summary = adjust_window(*map, images, 1, config);
  std::vector<std::shared_ptr<const Frame>> frames;
  for (const auto& v : key_images) frames.push_back(v->frame);
  const auto placed = placement(make_window(*map, images, summary), frames);
  move(*map, placed.survey_from_odometry);
  map->scale = placed.scale;
  map->axes = placed.axes;
  map->uncertain = placed.uncertain;
  const Frame& first = *key_images.front()->frame;
  if (map->submap > 0) {
    out.alerts.push_back({first.time, first.image, AlertKind::submap_started,
                          "sub-map " + std::to_string(map->submap) + " starts at image " +
                              std::to_string(first.image) +
                              (placed.uncertain ? ", its place is uncertain" : ""),
                          "it is mapped apart from what came before; swim back to the last good "
                          "ground to go on there"});
  }
  if (alerted || told_no_map) {
    out.alerts.push_back({out.shot ? out.shot->time : first.time,
                          out.shot ? out.shot->image : first.image, AlertKind::tracking_recovered,
                          map->submap > 0 ? "tracking again in a new sub-map" : "a map was started",
                          "none needed"});
  }
  tracking = TrackingState::tracking;
  std::erase_if(waiting, [&](const auto& v) {
    return std::find(key_images.begin(), key_images.end(), v) != key_images.end();
  });
  track.clear();
  for (const KeyFrame& k : map->key_frames) track.push_back({k.time, k.camera_from_map});
  track.erase(track.begin(), track.end() - 2);
  for (const KeyFrame& k : map->key_frames) out.poses.push_back(pose_of(*map, k));
  for (int k = 0; k < images; ++k) tell_health(*map, k, config, out);
  publish_window(summary, images, out);
  orient_waiting(out);
  alerted = told_no_map = false;
  key_images.clear();
  return true;
}

// A single camera tells the ground's slope from its own motion only over a long base; a pair sees
// depths from the first image on.
std::size_t VisualOdometry::State::images_to_start() const {
  const Frame& first = *key_images.front()->frame;
  const bool pair = first.rig->right && !first.right.empty();
  return pair ? kFewestStarting : static_cast<std::size_t>(config.initial_images);
}

// No more images follow that see this ground: a map of few is better than none.
bool VisualOdometry::State::start_early(Orientation& out) {
  return key_images.size() >= kFewestStarting && start(out);
}

void VisualOdometry::State::orient_waiting(Orientation& out) {
  for (const auto& view : waiting) {
    const auto result =
        resect_here(*view, std::nullopt, config.relocalise_key_frames, Effort::quick);
    if (!result.resection) {
      out.lost.push_back(view->frame->image);
      continue;
    }
    out.poses.push_back(pose_of(*map, *view->frame, *result.resection));
    Health health = health_of(*view, config);
    count(health, *map, *result.resection, config);
    tell(health, *view, out);
  }
  waiting.clear();
  key_images.clear();
}

void VisualOdometry::State::give_up_waiting(Orientation& out) {
  for (const auto& v : waiting) out.lost.push_back(v->frame->image);
  waiting.clear();
  key_images.clear();
  unfit = false;
  if (tracking == TrackingState::initialising) tracking = TrackingState::waiting;
}

void VisualOdometry::State::accept(const std::shared_ptr<const View>& view,
                                   const Resection& resection, Orientation& out) {
  count(out.health, *map, resection, config);
  alerted = false;
  const auto shorter = std::min(view->camera().width, view->camera().height);
  const bool new_ground = shift_since_last(*map, resection) > config.key_frame_shift * shorter ||
                          static_cast<int>(resection.seen.size()) < config.tie_points / 4;
  Rigid3 pose = resection.camera_from_map;
  if (new_ground) {
    stereo_check.observe(*view->frame, add_key_frame(*map, view, resection), out.alerts);
    add_tie_points(*map, config);
    const int fixed = map->rig->right ? 1 : 2;
    auto summary = adjust_window(*map, config.window, fixed, config);
    if (static_cast<int>(resection.seen.size()) < config.tie_points / 4) {
      // Few tie points gave a pose too rough to find many new ones; now it is better.
      add_tie_points(*map, config);
      summary = adjust_window(*map, config.window, fixed, config);
    }
    const std::size_t n = map->key_frames.size();
    for (std::size_t k = n - std::min(n, static_cast<std::size_t>(config.window)); k < n; ++k) {
      out.poses.push_back(pose_of(*map, map->key_frames[k]));
    }
    for (Follower& f : followers) {
      f.pose.survey_from_camera =
          (f.camera_from_key_frame * map->key_frame(f.key_frame).camera_from_map).inverse();
      out.poses.push_back(f.pose);
    }
    std::erase_if(followers, [&](const Follower& f) {
      return f.key_frame + config.window <= static_cast<int>(n);
    });
    publish_window(summary, config.window, out);
    append(out.settled, retire(*map, config));
    pose = map->last().camera_from_map;
  } else {
    const ImagePose image_pose = pose_of(*map, *view->frame, resection);
    out.poses.push_back(image_pose);
    followers.push_back({image_pose, static_cast<int>(map->key_frames.size()) - 1,
                         pose * map->last().camera_from_map.inverse()});
    if (followers.size() > kMaxFollowers) followers.erase(followers.begin());
  }
  track.push_back({view->frame->time, pose});
  if (track.size() > 2) track.erase(track.begin());
}

void VisualOdometry::State::publish_window(const AdjustmentSummary& summary, int images,
                                           Orientation& out) {
  Window window = make_window(*map, images, summary);
  // A young map's window grows to its size; twice then the central image stays the same.
  const std::uint64_t central = window.central->image;
  if (std::exchange(last_central, central) != central) {
    for (const int point : std::exchange(map->given_up, {})) {
      window.given_up.push_back(map->first_id + static_cast<std::uint64_t>(point));
    }
    out.window = std::make_shared<const Window>(std::move(window));
  }
  // Whoever keeps tie points in blocks of ids has one sub-map's in each.
  constexpr std::uint64_t kBlock = 1024;
  next_id = (map->first_id + map->points.size() + kBlock - 1) / kBlock * kBlock;
}

ResectionResult VisualOdometry::State::resect_here(const View& view,
                                                   const std::optional<Rigid3>& predicted,
                                                   int key_frames, Effort effort) {
  std::vector<int> references;
  const int last = static_cast<int>(map->key_frames.size()) - 1;
  for (int k = last; k >= 0 && k > last - key_frames; --k) references.push_back(k);
  return resect(*map, view, predicted, references, config, effort);
}

VisualOdometry::VisualOdometry(Config config, Placement placement)
    : state_(std::make_unique<State>()) {
  config.check();
  NADIR_CHECK(placement != nullptr);
  state_->config = config;
  state_->placement = std::move(placement);
}
VisualOdometry::VisualOdometry(VisualOdometry&&) noexcept = default;
VisualOdometry& VisualOdometry::operator=(VisualOdometry&&) noexcept = default;
VisualOdometry::~VisualOdometry() = default;

Orientation VisualOdometry::process(std::shared_ptr<const Shot> shot) {
  Orientation out;
  out.shot = std::move(shot);
  if (out.shot->frame) {
    const auto view = prepare_view(out.shot->frame, state_->config.features);
    view->frame = state_->stereo_check.passed(*view, out.alerts);
    out.health = health_of(*view, state_->config);
    state_->process(view, out);
  }
  out.state = state_->tracking;
  out.submap = state_->map ? state_->map->submap : 0;
  return out;
}

void VisualOdometry::begin_submap() { state_->begin_submap(); }

Orientation VisualOdometry::finish() {
  Orientation out;
  state_->start_early(out);
  if (!state_->map && !state_->waiting.empty()) {
    out.alerts.push_back(no_map_alert(*state_->waiting.back()->frame));
  }
  state_->give_up_waiting(out);
  if (state_->map) append(out.settled, retire_all(*state_->map));
  out.state = state_->tracking;
  out.submap = state_->map ? state_->map->submap : 0;
  return out;
}

}  // namespace nadir::odometry
