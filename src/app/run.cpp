// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The live service: waits for what is missing, maps, and tells the service manager that it lives.
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <memory>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "configured.hpp"
#include "dive_course.hpp"
#include "earlier_dives.hpp"
#include "interrupt.hpp"
#include "nadir/capture/camera_source.hpp"
#include "nadir/core/check.hpp"
#include "page_assets.hpp"
#include "service_manager.hpp"
#include "variation.hpp"
#include "verbs.hpp"
#include "watch.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

Time monotonic_now() {
  return std::chrono::nanoseconds(Watch::Clock::now().time_since_epoch()).count();
}

void log(const Alert& alert) {
  std::fprintf(stderr, "%s: %s; %s\n", std::string(to_string(alert.kind)).c_str(),
               alert.message.c_str(), alert.remedy.c_str());
}

/// Until the graph runs, this thread alone speaks to the page.
class Beginning {
 public:
  Beginning(const Config& config, ServiceManager& manager, const std::stop_token& stop)
      : config_(config), manager_(manager), stop_(stop) {}

  std::unique_ptr<serve::WebServer> open_page();
  std::optional<Shot> first_image(capture::CameraSource& cameras, Publisher& page);
  Config with_variation(Publisher& page);
  std::unique_ptr<record::Dive> begin_dive(capture::CameraSource& cameras, Publisher& page);

  /// Told already, to be recorded with the dive.
  const std::vector<Alert>& alerts() const { return alerts_; }

 private:
  void tell(const Alert& alert, Publisher& page);
  bool pause() const;

  const Config& config_;
  ServiceManager& manager_;
  const std::stop_token stop_;
  std::vector<Alert> alerts_;
};

void Beginning::tell(const Alert& alert, Publisher& page) {
  log(alert);
  page.publish(alert);
  constexpr std::size_t kMost = 1000;
  if (alerts_.size() < kMost) alerts_.push_back(alert);
}

// False when told to stop.
bool Beginning::pause() const {
  manager_.feed_watchdog();
  std::mutex alone;
  std::unique_lock lock(alone);
  std::condition_variable_any().wait_for(lock, stop_, 1s, [] { return false; });
  return !stop_.stop_requested();
}

// A port that another program holds may be free in a moment. Null when told to stop.
std::unique_ptr<serve::WebServer> Beginning::open_page() {
  std::string told;
  do {
    try {
      return std::make_unique<serve::WebServer>(config_.serve, page_assets(), manager_.socket());
    } catch (const InputError& error) {
      if (manager_.socket()) throw;
      if (std::exchange(told, error.what()) != error.what())
        std::fprintf(stderr, "%s; it is tried again every second\n", error.what());
      manager_.status("waiting for the page's port");
    }
  } while (pause());
  return nullptr;
}

// None when told to stop.
std::optional<Shot> Beginning::first_image(capture::CameraSource& cameras, Publisher& page) {
  manager_.status("waiting for the camera");
  while (auto captured = cameras.next(stop_)) {
    manager_.feed_watchdog();
    for (const Alert& alert : captured->alerts) tell(alert, page);
    if (captured->shot) return captured->shot;
  }
  return std::nullopt;
}

// Once images come: by then the clock may have been set.
Config Beginning::with_variation(Publisher& page) {
  Config config = config_;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto variation = variation_by_model(config, std::chrono::nanoseconds(now).count());
  if (!variation) return config;
  config.sensors.magnetic_variation_deg = variation->degrees;
  std::fprintf(stderr, "magnetic variation by the model: %+.1f degrees\n", variation->degrees);
  if (std::optional<Alert> alert = variation->alert) {
    alert->time = monotonic_now();
    tell(*alert, page);
  }
  return config;
}

// Null when told to stop.
std::unique_ptr<record::Dive> Beginning::begin_dive(capture::CameraSource& cameras,
                                                    Publisher& page) {
  const Time to_utc =
      std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count() -
      monotonic_now();
  // Images are stamped by a clock that begins with the computer.
  const nlohmann::json input{{"camera", config_.capture.camera},
                             {"camera_right", config_.capture.camera_right},
                             {"utc_minus_time_s", seconds(to_utc)},
                             {"utc_is_set", clock_is_set()}};
  std::string told;
  do {
    try {
      const auto folder = new_dive(config_.record.dives);
      record::DiveInfo info = dive_info(input, "odometry", config_);
      info.survey_files = capture::calibration_files(config_.capture);
      auto dive = std::make_unique<record::Dive>(folder, info, config_.record);
      std::fprintf(stderr, "the dive: %s\n", folder.c_str());
      for (const Alert& alert : alerts_) dive->add(alert);
      return dive;
    } catch (const InputError& error) {
      if (std::exchange(told, error.what()) != error.what()) {
        tell({monotonic_now(), std::nullopt, AlertKind::storage, error.what(),
              "mapping begins by itself as soon as it can be recorded"},
             page);
      }
      manager_.status("waiting for the disk");
    }
    cameras.next(stop_);  // what they see meanwhile is not kept
  } while (pause());
  return nullptr;
}

std::string in_words(const Graph& graph) {
  std::uint64_t images = 0;
  double rate = 0;
  for (const StageStats& stage : graph.stats()) {
    if (stage.stage != "odometry") continue;
    images = stage.processed;
    rate = stage.rate_out_hz;
  }
  char text[64];
  std::snprintf(text, sizeof text, "mapping: %llu images, %.1f a second",
                static_cast<unsigned long long>(images), rate);
  return text;
}

/// Of what came to the stages in the last seconds, the part that found no room.
class DropRate {
 public:
  double observe(const std::vector<StageStats>& stages) {
    constexpr std::size_t kCalls = 10;
    Count count;
    for (const StageStats& stage : stages) {
      if (stage.stage == "outputs") continue;  // datagrams may be lost
      count.dropped += stage.dropped;
      if (stage.stage == "odometry") count.images = stage.processed + stage.dropped;
    }
    counts_.push_back(count);
    if (counts_.size() > kCalls + 1) counts_.pop_front();
    const double images = static_cast<double>(count.images - counts_.front().images);
    return images > 0 ? static_cast<double>(count.dropped - counts_.front().dropped) / images : 0;
  }

 private:
  struct Count {
    std::uint64_t images = 0, dropped = 0;
  };
  std::deque<Count> counts_;  ///< two a second
};

// Until told to stop or a stage has ended by a fault. A stage that hangs cannot be ended: the
// process has to be, and the journal is whole at any instant.
void supervise(Graph& graph, const Config& config, ServiceManager& manager,
               const std::stop_token& stop) {
  Watch watch;
  Ladder ladder;
  DropRate drop_rate;
  std::mutex alone;
  std::unique_lock lock(alone);
  while (!stop.stop_requested()) {
    if (const auto stage = watch.hung(Watch::Clock::now(), graph.activities())) {
      std::fprintf(stderr, "load: the stage %s hangs; nadir starts again\n", stage->c_str());
      manager.trigger_watchdog();
      std::_Exit(1);
    }
    manager.feed_watchdog();
    Load load = board_load("/sys", config.record.dives);
    load.dropped = drop_rate.observe(graph.stats());
    const Economy economy = ladder.observe(Watch::Clock::now(), load);
    graph.economise(economy, ladder.reason(), monotonic_now());
    manager.status(in_words(graph));
    std::condition_variable_any().wait_for(lock, stop, 500ms, [] { return false; });
  }
}

}  // namespace

int run(const Run& live) {
  const Config config = configured(live.settings, live.serve);
  ServiceManager manager;
  cv::setNumThreads(1);
  Interrupt interrupt;
  std::stop_source stop;
  interrupt.on_interrupt([stop]() mutable { stop.request_stop(); });
  const auto begun = Watch::Clock::now();
  capture::CameraSource cameras(config.capture, config.record.originals != record::Originals::none);

  Beginning beginning(config, manager, stop.get_token());
  const auto server = beginning.open_page();
  if (!server) return 0;
  std::fprintf(stderr, "the map: %s\n", page_url(config.serve.address, server->port()).c_str());
  manager.ready();
  const Recoveries recoveries(unfinished_dives(config.record.dives));
  Publisher page(*server, "live", 0);
  std::optional<Shot> first = beginning.first_image(cameras, page);
  if (!first) return 0;
  const Config mapping = beginning.with_variation(page);
  const auto dive = beginning.begin_dive(cameras, page);
  if (!dive) return 0;

  Progress progress(0, stderr);
  const auto next = [&](const std::stop_token& ending) -> std::optional<capture::Captured> {
    if (first) return capture::Captured{std::exchange(first, std::nullopt), {}};
    return cameras.next(ending);
  };
  const auto note_speed = [&](double px_a_second) { cameras.note_speed(px_a_second); };
  Graph graph(mapping, {Rate::Kind::live, 0},
              {next, cameras.lasers(), note_speed, *dive, &page, progress});
  interrupt.on_interrupt([stop = graph.stop_source()]() mutable { stop.request_stop(); });
  supervise(graph, config, manager, graph.stop_source().get_token());
  manager.stopping();
  // The files of a long dive take their time.
  const std::jthread alive([&](const std::stop_token& done) {
    std::mutex alone;
    std::unique_lock lock(alone);
    while (!done.stop_requested()) {
      manager.feed_watchdog();
      std::condition_variable_any().wait_for(lock, done, 1s, [] { return false; });
    }
  });
  return finish_dive({graph, *dive, &page, progress, begun});
}

}  // namespace nadir::app
