// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What each stage does with one message, and what it hands on.
#include <algorithm>

#include "graph.hpp"
#include "pause.hpp"

namespace nadir::app {
namespace {

Alert skipped(const Orientation& orientation, std::uint32_t count) {
  const Shot* shot = orientation.shot.get();
  return {shot ? shot->time : 0, shot ? std::optional(shot->image) : std::nullopt, AlertKind::load,
          std::to_string(count) +
              " images were oriented but not wholly mapped, the processor could not keep up",
          "lower the image rate or capture.scale; replay the images later for the whole map"};
}

}  // namespace

void Dropped::add(std::uint64_t image, Time time, std::vector<Alert> own) {
  ++images;
  last_image = image;
  last_time = time;
  alerts.insert(alerts.end(), own.begin(), own.end());
}

std::vector<Alert> Dropped::told(std::uint64_t image, Time time) const {
  std::vector<Alert> all = alerts;
  if (images > 0) {
    all.push_back({time, image, AlertKind::images_dropped,
                   std::to_string(images) + " images up to image " + std::to_string(last_image) +
                       " were dropped, odometry could not keep up",
                   "lower the image rate or capture.scale"});
  }
  return all;
}

bool Graph::capture_one() {
  if (stop_.stop_requested()) return false;
  std::optional<capture::Captured> captured = ends_.capture(stop_.get_token());
  if (!captured) return false;
  for (const Alert& alert : captured->alerts)
    capture_alerts_.push(std::make_shared<const Alert>(alert));
  if (!captured->shot) return true;
  if (!wait_for(*captured->shot)) return false;
  pass_on(*std::move(captured->shot));
  return true;
}

void Graph::pass_on(Shot shot) {
  std::vector<Alert> own = shot.alerts;
  const std::uint64_t image = shot.image;
  const std::uint32_t missed = shot.missed_before;
  const Time time = shot.time;
  shot.dropped_before += dropped_.images;
  shot.missed_before += dropped_.missed;
  std::vector<Alert> before = dropped_.told(image, time);
  shot.alerts.insert(shot.alerts.begin(), before.begin(), before.end());
  if (shots_.push(std::make_shared<const Shot>(std::move(shot)))) {
    dropped_ = {};
  } else {
    dropped_.add(image, time, std::move(own));
    dropped_.missed += missed;
  }
}

// Until told to stop; what the sensors say then is of no use any more.
bool Graph::listen() {
  const auto heard = [this](const sensors::Heard& reading) {
    readings_.push(std::make_shared<const sensors::Heard>(reading));
  };
  const auto link = [this](const sensors::LinkChange& change) {
    if (change.fault.empty()) return;
    sensor_alerts_.push(std::make_shared<const Alert>(
        Alert{change.time, std::nullopt, AlertKind::sensor_stale, change.fault,
              "check the sensor, its cable and sensors.inputs; it is tried again every second"}));
  };
  sensors::Listener(sensor_inputs_, {heard, link}).run(stop_.get_token());
  return false;
}

void Graph::hear(const sensors::Heard& heard) {
  vehicle_.hear(heard.input, heard.time, heard.reading);
  utc_offset_ = vehicle_.utc_offset().value_or(kUnknown);
}

// What the vehicle's sensors say of a live image.
Graph::Shared<Shot> Graph::with_sensors(Shared<Shot> shot) {
  if (sensor_inputs_.empty()) return shot;
  Shot marked = *shot;
  std::vector<Alert> alerts = vehicle_.new_alerts(shot->time, shot->image);
  std::ranges::move(alerts, std::back_inserter(marked.alerts));
  if (shot->frame) {
    Frame frame = *shot->frame;
    vehicle_.mark(frame);
    marked.frame = std::make_shared<const Frame>(std::move(frame));
  }
  return std::make_shared<const Shot>(std::move(marked));
}

void Graph::orient(Shared<Shot> shot) {
  if (auto* own = std::get_if<odometry::VisualOdometry>(&odometry_);
      own && submap_wanted_.exchange(false)) {
    own->begin_submap();
  }
  shot = survey_.mark(with_sensors(std::move(shot)));
  pass_on(std::visit([&](auto& engine) { return engine.process(std::move(shot)); }, odometry_));
}

void Graph::pass_on(Orientation orientation) {
  if (ends_.note_speed) {
    // Without a map the light alone decides.
    ends_.note_speed(image_speed_.observe(orientation).value_or(0));
  }
  std::vector<Alert> conflicts = survey_.observe(orientation);
  std::ranges::move(conflicts, std::back_inserter(orientation.alerts));
  orientation.dead_reckoned = survey_.dead_reckon(orientation);
  orientation.axes = survey_.axes();
  if (windows_skipped_ > 0) orientation.alerts.push_back(skipped(orientation, windows_skipped_));
  Settlement settlement;
  if (orientation.shot) {
    settlement.image = orientation.shot->image;
    settlement.time = orientation.shot->time;
  }
  settlement.key_frames = std::move(orientation.settled);
  settlement.scales = survey_.improved_scales(orientation);
  const auto message = std::make_shared<const Orientation>(std::move(orientation));
  newest_ = message;
  recorded_orientations_.push(message);
  settlements_.push(std::make_shared<const Settlement>(std::move(settlement)));
  to_page(page_orientations_, message);
  if (outputs_) output_orientations_.push(message);
  windows_skipped_ = orientations_.push(message) ? 0 : windows_skipped_ + 1;
}

void Graph::fit(Shared<Orientation> orientation) {
  Surface surface = plane_.process(std::move(orientation));
  if (surfaces_skipped_ > 0)
    surface.alerts.push_back(skipped(*surface.orientation, surfaces_skipped_));
  const auto message = std::make_shared<const Surface>(std::move(surface));
  recorded_surfaces_.push(message);
  to_page(page_surfaces_, message);
  const bool projected = projection_surfaces_.push(message);
  const bool stitched = mosaic_surfaces_.push(message);
  surfaces_skipped_ = projected && stitched ? 0 : surfaces_skipped_ + 1;
}

void Graph::project(Shared<Surface> surface) {
  constexpr std::uint64_t kOneOf = 4;
  const bool passed_over = economy_ >= Economy::projection && surfaces_projected_++ % kOneOf != 0;
  const auto message = std::make_shared<const Cloud>(
      passed_over ? Cloud{std::move(surface), {}, {}} : projection_.process(std::move(surface)));
  recorded_clouds_.push(message);
  to_page(page_clouds_, message);
  if (outputs_) output_clouds_.push(message);
}

void Graph::stitch(Shared<Surface> surface) {
  mosaicker_.coarsen(economy_ >= Economy::mosaic ? 2 : 1);
  const auto message = std::make_shared<const MosaicUpdate>(mosaicker_.process(std::move(surface)));
  recorded_mosaics_.push(message);
  to_page(page_mosaics_, message);
}

void Graph::look_back(const Shared<Settlement>& settlement) {
  const auto message = std::make_shared<const Revision>(revisit_.process(*settlement));
  recorded_revisions_.push(message);
  to_page(page_revisions_, message);
}

void Graph::write(const record::Entry& entry) {
  const std::vector<Alert> alerts = ends_.dive.add(entry);
  ends_.progress.add(entry);
  if (const Shot* shot = entry.orientation->shot.get(); shot && ends_.live) {
    ends_.live->note(ends_.dive.saved(), ends_.dive.is_paused(), shot->time);
  }
  for (const Alert& alert : alerts) tell(alert);
}

// Pages are sent only what is durable.
void Graph::keep(const Mark& mark) {
  if (ends_.dive.add(mark)) {
    to_page(page_marks_, std::make_shared<const Mark>(mark));
  } else {
    tell({mark.time, mark.image, AlertKind::storage,
          std::string("a mark could not be ") + (mark.removed ? "removed" : "recorded"),
          "free space on the disk, then do it again"});
  }
}

void Graph::tell(const Alert& alert) {
  ends_.progress.add(alert);
  to_page(page_alerts_, std::make_shared<const Alert>(alert));
}

void Graph::economise(Economy economy, const std::string& reason, Time now) {
  if (economy_.exchange(economy) == economy) return;
  if (ends_.page) ends_.page->slow_down(economy >= Economy::live_image);
  load_alerts_.push(std::make_shared<const Alert>(Alert{now, std::nullopt, AlertKind::load,
                                                        reason + ": " + in_words(economy),
                                                        "images and poses are recorded as ever"}));
}

void Graph::show(const wire::Check& check) {
  if (ends_.page) page_checks_.push(std::make_shared<const wire::Check>(check));
}

void Graph::note(Board board) {
  if (!ends_.page) return;
  const Time by_sensors = utc_offset_;
  if (!board.utc_offset && by_sensors != kUnknown) board.utc_offset = by_sensors;
  ends_.page->note(board);
}

void Graph::publish_statistics() {
  constexpr auto kPeriod = std::chrono::seconds(1);
  const auto now = std::chrono::steady_clock::now();
  if (!started_ || now - told_ < kPeriod) return;
  told_ = now;
  ends_.page->publish(stats());
}

// A replay at a given rate hands an image out when a camera would have. False when told to stop
// meanwhile.
bool Graph::wait_for(const Shot& shot) {
  constexpr double kLongestWait = 86400;  // s; times far apart are a mistake in a file
  if (!first_time_) first_time_ = shot.time;
  double due_s = 0;
  if (rate_.kind == Rate::Kind::fixed) due_s = static_cast<double>(shots_taken_) / rate_.hz;
  if (rate_.kind == Rate::Kind::recorded) due_s = seconds(shot.time) - seconds(*first_time_);
  ++shots_taken_;
  const auto wait = std::chrono::duration<double>(std::clamp(due_s, 0.0, kLongestWait));
  return pause_until(begun_ + std::chrono::duration_cast<std::chrono::nanoseconds>(wait),
                     stop_.get_token());
}

}  // namespace nadir::app
