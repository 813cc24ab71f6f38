// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "graph.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

using pipeline::WhenFull;

// Messages hold their images, so queues are short; the recorder's lets a slow card catch its
// breath.
constexpr std::size_t kDepth = 4;
constexpr std::size_t kRecordDepth = 16;
// At --rate max nothing is lost by waiting, and a projected image and its tiles are tens of MB.
constexpr std::size_t kMosaicDepth = 1;
// A long adjustment of the map must not hold up odometry. At --rate max it may: whatever belongs to
// a shot waits for its revision to be recorded, images too.
constexpr std::size_t kSettlementDepth = 256;
// An image that waits in a queue is old when it is shown.
constexpr std::size_t kLiveDepth = 2;
// An AHRS at 100 Hz, while odometry takes ten seconds for an image.
constexpr std::size_t kReadingDepth = 1024;
constexpr std::size_t kAlertDepth = 64;

// At --rate max every edge waits and nothing is lost. Otherwise the working edges drop as they do
// live. Those to the recorder and the page wait: the recorder must have every pose, and neither
// ever waits for a network.
WhenFull when_full(const Rate& rate) {
  return rate.kind == Rate::Kind::max ? WhenFull::wait : WhenFull::drop;
}

// A replay's sensors are the logs beside its images.
std::vector<sensors::Input> sensor_inputs_of(const Config& config, const Rate& rate) {
  return sensors::parse_inputs(rate.kind == Rate::Kind::live ? config.sensors.inputs : "");
}

std::vector<std::string> names_of(const std::vector<sensors::Input>& inputs) {
  std::vector<std::string> names;
  std::ranges::transform(inputs, std::back_inserter(names), &sensors::Input::name);
  return names;
}

reference::SurveyFrame::PlaneOf plane_of(const plane::Config& config) {
  return [config](const Window& window) {
    return plane::fit_plane(window.tie_points, window.images, config).plane;
  };
}

// An AHRS that may not level the survey has no say in odometry either.
odometry::Config with_attitude_as_wanted(const Config& config) {
  odometry::Config odometry = config.odometry;
  if (!config.reference.attitude) odometry.attitude_sigma_deg = odometry.heading_sigma_deg = 0;
  return odometry;
}

// One that odometry leaves out is still checked, as if it were a usual one.
reference::AttitudeSigma attitude_sigma_of(const odometry::Config& odometry) {
  reference::AttitudeSigma sigma;
  if (odometry.attitude_sigma_deg > 0) sigma.tilt_deg = odometry.attitude_sigma_deg;
  if (odometry.heading_sigma_deg > 0) sigma.heading_deg = odometry.heading_sigma_deg;
  return sigma;
}

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

Graph::Odometry Graph::make_odometry(const odometry::Config& config,
                                     std::optional<GivenPoses> poses) {
  const auto place = [this](const Window& initial, const std::vector<Shared<Frame>>& frames) {
    return survey_.place(initial, frames);
  };
  if (poses) return odometry::PosedImages(config, *std::move(poses), place);
  return odometry::VisualOdometry(config, place);
}

Graph::Graph(const Config& config, Rate rate, Ends ends, std::optional<GivenPoses> poses)
    : rate_(rate),
      ends_(ends),
      sensor_inputs_(sensor_inputs_of(config, rate)),
      vehicle_(config.sensors, names_of(sensor_inputs_)),
      survey_(config.reference, plane_of(config.plane), ends.lasers,
              attitude_sigma_of(config.odometry)),
      odometry_(make_odometry(with_attitude_as_wanted(config), std::move(poses))),
      plane_(config.plane),
      mosaicker_(config.mosaic2d),
      projection_(config.projection3d),
      revisit_(config.revisit),
      assembler_(rate.kind == Rate::Kind::max ? Assembler::Revisions::in_step
                                              : Assembler::Revisions::as_come,
                 [this](const record::Entry& entry) { write(entry); }),
      readings_(kReadingDepth, WhenFull::drop, odometry_bell_),
      shots_(rate.kind == Rate::Kind::live ? kLiveDepth : kDepth, when_full(rate), odometry_bell_),
      capture_alerts_(kAlertDepth, WhenFull::drop, record_bell_),
      sensor_alerts_(kAlertDepth, WhenFull::drop, record_bell_),
      load_alerts_(kAlertDepth, WhenFull::drop, record_bell_),
      orientations_(kDepth, when_full(rate)),
      recorded_orientations_(kRecordDepth, WhenFull::wait, record_bell_),
      page_orientations_(kDepth, WhenFull::wait, page_bell_),
      projection_surfaces_(kDepth, when_full(rate)),
      mosaic_surfaces_(kDepth, when_full(rate)),
      recorded_surfaces_(kRecordDepth, WhenFull::wait, record_bell_),
      page_surfaces_(kDepth, WhenFull::wait, page_bell_),
      recorded_clouds_(kRecordDepth, WhenFull::wait, record_bell_),
      page_clouds_(kDepth, WhenFull::wait, page_bell_),
      recorded_mosaics_(rate.kind == Rate::Kind::max ? kMosaicDepth : kRecordDepth, WhenFull::wait,
                        record_bell_),
      page_mosaics_(kDepth, WhenFull::wait, page_bell_),
      settlements_(rate.kind == Rate::Kind::max ? kDepth : kSettlementDepth, WhenFull::wait),
      recorded_revisions_(kRecordDepth, WhenFull::wait, record_bell_),
      page_revisions_(kDepth, WhenFull::wait, page_bell_),
      page_alerts_(kDepth, WhenFull::wait, page_bell_),
      output_orientations_(kDepth, WhenFull::drop, output_bell_),
      output_clouds_(kDepth, WhenFull::drop, output_bell_) {
  if (rate.kind == Rate::Kind::live && !config.sensors.outputs.empty()) outputs_.emplace(config);
  start_stages();
}

// A stage that throws ends the source, so that the others drain and what was recorded is kept.
template <class T, class Process>
pipeline::Input Graph::feed(Channel<T>& channel, Process process) {
  return pipeline::from(channel, [this, process = std::move(process)](Shared<T> message) mutable {
    try {
      process(std::move(message));
    } catch (...) {
      stop_.request_stop();
      throw;
    }
  });
}

// Downstream first, so that every channel has its reader before its writer.
void Graph::start_stages() {
  using pipeline::Stage;
  if (ends_.page) {
    Publisher& page = *ends_.page;
    page_ = std::make_unique<Stage>(
        "page",
        std::vector{
            feed(page_alerts_, [&](const Shared<Alert>& alert) { page.publish(*alert); }),
            feed(page_orientations_,
                 [&](const Shared<Orientation>& orientation) {
                   page.publish(*orientation);
                   publish_statistics();
                 }),
            feed(page_surfaces_, [&](const Shared<Surface>& surface) { page.publish(*surface); }),
            feed(page_clouds_, [&](const Shared<Cloud>& cloud) { page.publish(*cloud); }),
            feed(page_mosaics_, [&](const Shared<MosaicUpdate>& mosaic) { page.publish(*mosaic); }),
            feed(page_revisions_,
                 [&](const Shared<Revision>& revision) { page.publish(*revision); })},
        [] {});
  }
  if (outputs_) {
    outputs_stage_ = std::make_unique<Stage>(
        "outputs",
        std::vector{
            feed(output_orientations_,
                 [this](const Shared<Orientation>& o) { outputs_->process(*o); }),
            feed(output_clouds_, [this](const Shared<Cloud>& c) { outputs_->process(*c); })},
        [] {});
  }
  const auto assemble = [this](auto message) { assembler_.add(std::move(message)); };
  const auto announce = [this](const Shared<Alert>& alert) {
    ends_.dive.add(*alert);
    tell(*alert);
  };
  record_ = std::make_unique<Stage>(
      "record",
      std::vector{feed(capture_alerts_, announce), feed(sensor_alerts_, announce),
                  feed(load_alerts_, announce), feed(recorded_orientations_, assemble),
                  feed(recorded_surfaces_, assemble), feed(recorded_clouds_, assemble),
                  feed(recorded_mosaics_, assemble), feed(recorded_revisions_, assemble)},
      [this] { page_alerts_.close(); }, [this] { assembler_.finish(); });
  revisiting_ = std::make_unique<Stage>(
      "revisit",
      std::vector{feed(settlements_, [this](const Shared<Settlement>& s) { look_back(s); })},
      [this] {
        recorded_revisions_.close();
        page_revisions_.close();
      });
  stitching_ = std::make_unique<Stage>(
      "mosaic2d",
      std::vector{feed(mosaic_surfaces_, [this](Shared<Surface> s) { stitch(std::move(s)); })},
      [this] {
        recorded_mosaics_.close();
        page_mosaics_.close();
      },
      [this] { mosaicker_.finish(); });
  projecting_ = std::make_unique<Stage>(
      "projection3d",
      std::vector{feed(projection_surfaces_, [this](Shared<Surface> s) { project(std::move(s)); })},
      [this] {
        recorded_clouds_.close();
        page_clouds_.close();
        output_clouds_.close();
      });
  fitting_ = std::make_unique<Stage>(
      "plane",
      std::vector{feed(orientations_, [this](Shared<Orientation> o) { fit(std::move(o)); })},
      [this] {
        projection_surfaces_.close();
        mosaic_surfaces_.close();
        recorded_surfaces_.close();
        page_surfaces_.close();
      });
  orienting_ = std::make_unique<Stage>(
      "odometry",
      std::vector{feed(readings_, [this](const Shared<sensors::Heard>& heard) { hear(*heard); }),
                  feed(shots_, [this](Shared<Shot> shot) { orient(std::move(shot)); })},
      [this] {
        orientations_.close();
        recorded_orientations_.close();
        page_orientations_.close();
        output_orientations_.close();
        settlements_.close();
      },
      [this] { pass_on(std::visit([](auto& engine) { return engine.finish(); }, odometry_)); });
  capture_ = std::make_unique<Stage>(
      "capture", [this] { return capture_one(); },
      [this] {
        shots_.close();
        capture_alerts_.close();
        stop_.request_stop();  // also of a fault of its own
      });
  const auto close_sensors = [this] {
    readings_.close();
    sensor_alerts_.close();
  };
  if (sensor_inputs_.empty()) {
    close_sensors();
  } else {
    sensors_ = std::make_unique<Stage>(
        "sensors", [this] { return listen(); }, close_sensors);
  }
  started_ = true;
}

Graph::~Graph() {
  stop_.request_stop();
  join();
}

bool Graph::capture_one() {
  if (stop_.stop_requested()) return false;
  if (rate_.kind == Rate::Kind::live && !std::exchange(prioritised_, true)) prioritise_capture();
  std::optional<capture::Captured> captured = ends_.capture(stop_.get_token());
  if (!captured) return false;
  for (const Alert& alert : captured->alerts)
    capture_alerts_.push(std::make_shared<const Alert>(alert));
  if (!captured->shot) return true;
  if (!wait_for(*captured->shot)) return false;
  pass_on(*std::move(captured->shot));
  return true;
}

// A camera's few buffers must not overflow while everything else computes.
void Graph::prioritise_capture() {
  constexpr int kUrgent = 10;  // of 1 to 99
  const sched_param priority{kUrgent};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  if (error == 0) return;
  std::fprintf(stderr, "load: images are taken without priority (%s); nadir.service has it\n",
               std::strerror(error));
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
  for (const Alert& alert : alerts) tell(alert);
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
  std::mutex alone;
  std::unique_lock lock(alone);
  std::condition_variable_any().wait_until(
      lock, stop_.get_token(), begun_ + std::chrono::duration_cast<std::chrono::nanoseconds>(wait),
      [] { return false; });
  return !stop_.stop_requested();
}

std::exception_ptr Graph::join() {
  load_alerts_.close();  // of the caller's thread, which has no more to tell
  std::exception_ptr fault;
  for (const auto* stage : {&capture_, &orienting_, &fitting_, &projecting_, &stitching_,
                            &revisiting_, &record_, &page_, &outputs_stage_, &sensors_}) {
    if (!*stage) continue;
    if (const std::exception_ptr of_stage = (*stage)->join(); of_stage && !fault) fault = of_stage;
  }
  return fault;
}

std::vector<pipeline::StageActivity> Graph::activities() const {
  std::vector<pipeline::StageActivity> all;
  for (const auto* stage : {&capture_, &orienting_, &fitting_, &projecting_, &stitching_,
                            &revisiting_, &record_, &page_, &outputs_stage_}) {
    if (*stage) all.push_back((*stage)->activity());
  }
  return all;
}

std::vector<StageStats> Graph::stats() const {
  std::vector<StageStats> all;
  for (const auto* stage : {&capture_, &orienting_, &fitting_, &projecting_, &stitching_,
                            &revisiting_, &record_, &page_, &outputs_stage_}) {
    if (*stage) all.push_back((*stage)->stats());
  }
  return all;
}

}  // namespace nadir::app
