// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "graph.hpp"

#include <algorithm>

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
constexpr std::size_t kMarkDepth = 64;

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

}  // namespace

Graph::Odometry Graph::make_odometry(const odometry::Config& config,
                                     std::optional<GivenPoses> poses) {
  const auto place = [this](const Window& initial, const std::vector<Shared<Frame>>& frames) {
    return survey_.place(initial, frames);
  };
  if (poses) return odometry::PosedImages(config, *std::move(poses), place);
  return odometry::VisualOdometry(config, place);
}

Graph::Graph(const Config& config, Rate rate, const Ends& ends, std::optional<GivenPoses> poses)
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
      marks_(kMarkDepth, WhenFull::drop, record_bell_),
      page_marks_(kDepth, WhenFull::wait, page_bell_),
      page_checks_(kDepth, WhenFull::drop, page_bell_),
      output_orientations_(kDepth, WhenFull::drop, output_bell_),
      output_clouds_(kDepth, WhenFull::drop, output_bell_) {
  if (rate.kind == Rate::Kind::live && !config.sensors.outputs.empty()) outputs_.emplace(config);
  if (ends_.live) {
    ends_.live->record_marks(
        [this](const Mark& mark) { return marks_.push(std::make_shared<const Mark>(mark)); });
  }
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
            feed(page_marks_, [&](const Shared<Mark>& mark) { page.publish(*mark); }),
            feed(page_checks_, [&](const Shared<wire::Check>& check) { page.publish(*check); }),
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
                  feed(load_alerts_, announce),
                  feed(marks_, [this](const Shared<Mark>& mark) { keep(*mark); }),
                  feed(recorded_orientations_, assemble), feed(recorded_surfaces_, assemble),
                  feed(recorded_clouds_, assemble), feed(recorded_mosaics_, assemble),
                  feed(recorded_revisions_, assemble)},
      [this] {
        page_alerts_.close();
        page_marks_.close();
      },
      [this] { assembler_.finish(); });
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
        if (ends_.live) ends_.live->record_marks({});  // from here on nobody pushes any
        marks_.close();
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

std::exception_ptr Graph::join() {
  // Of the caller's thread, which has no more to tell.
  load_alerts_.close();
  page_checks_.close();
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
