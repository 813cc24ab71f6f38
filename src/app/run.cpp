// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The live service: waits for what is missing, maps, and tells the service manager that it lives.
#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "configured.hpp"
#include "dive_course.hpp"
#include "drop_rate.hpp"
#include "earlier_dives.hpp"
#include "heartbeat.hpp"
#include "interrupt.hpp"
#include "live_check.hpp"
#include "nadir/capture/camera_source.hpp"
#include "nadir/core/check.hpp"
#include "nadir/pipeline/progress.hpp"
#include "nadir/record/disk.hpp"
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

Time utc_now() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

void log(const Alert& alert) {
  std::fprintf(stderr, "%s: %s; %s\n", std::string(to_string(alert.kind)).c_str(),
               alert.message.c_str(), alert.remedy.c_str());
}

// What nadir.socket was made of must not keep a dive from being recorded.
std::unique_ptr<serve::WebServer> open_page(const serve::Config& config,
                                            const ServiceManager& manager) {
  std::unique_ptr<serve::WebServer> server;
  try {
    server = std::make_unique<serve::WebServer>(config, page_assets(), manager.socket(),
                                                serve::Listen::in_time);
  } catch (const InputError& error) {
    if (!manager.socket()) throw;
    std::fprintf(stderr, "%s\n", error.what());
    server = std::make_unique<serve::WebServer>(config, page_assets(), std::nullopt,
                                                serve::Listen::in_time);
  }
  if (server->port() != 0) {
    std::fprintf(stderr, "the map: %s\n", page_url(config.address, server->port()).c_str());
  } else {
    std::fprintf(stderr, "%s; it is tried every second\n", server->listen_fault().c_str());
  }
  return server;
}

// False when told to stop.
bool pause(Heartbeat& heart, const std::stop_token& stop) {
  heart.beat();
  std::mutex alone;
  std::unique_lock lock(alone);
  std::condition_variable_any().wait_for(lock, stop, 1s, [] { return false; });
  return !stop.stop_requested();
}

/// Until the graph runs, this thread alone speaks to the page.
class Beginning {
 public:
  Beginning(const Config& config, ServiceManager& manager, Heartbeat& heart, Publisher& page,
            std::stop_token stop)
      : config_(config), manager_(manager), heart_(heart), page_(page), stop_(std::move(stop)) {}

  std::unique_ptr<capture::CameraSource> open_cameras(LiveCheck& check);
  std::optional<Shot> first_image(capture::CameraSource& cameras, LiveCheck& check);
  Config with_variation();
  std::unique_ptr<record::Dive> begin_dive(capture::CameraSource& cameras, record::Disk& disk);

 private:
  void tell(const Alert& alert);
  void tell_once(AlertKind kind, const std::string& fault);
  void show_waiting(LiveCheck& check, const std::string& item, const std::string& fault,
                    const std::string& remedy);

  const Config& config_;
  ServiceManager& manager_;
  Heartbeat& heart_;
  Publisher& page_;
  const std::stop_token stop_;
  std::vector<Alert> alerts_;  ///< told already, to be recorded with the dive
  std::string fault_;          ///< told last
};

void Beginning::tell(const Alert& alert) {
  log(alert);
  page_.publish(alert);
  constexpr std::size_t kMost = 1000;
  if (alerts_.size() < kMost) alerts_.push_back(alert);
}

void Beginning::tell_once(AlertKind kind, const std::string& fault) {
  if (std::exchange(fault_, fault) == fault) return;
  tell({monotonic_now(), std::nullopt, kind, fault,
        "mapping begins by itself as soon as that is mended"});
}

void Beginning::show_waiting(LiveCheck& check, const std::string& item, const std::string& fault,
                             const std::string& remedy) {
  const Load load = board_load("/sys", config_.record.dives);
  const Finding missing{Verdict::bad, item, fault, remedy};
  if (const auto found = check.waiting(Watch::Clock::now(), load, missing)) page_.publish(*found);
}

// A new board has no calibration yet. Null when told to stop.
std::unique_ptr<capture::CameraSource> Beginning::open_cameras(LiveCheck& check) {
  do {
    try {
      const bool keep = config_.record.originals != record::Originals::none;
      return std::make_unique<capture::CameraSource>(config_.capture, keep);
    } catch (const InputError& error) {
      tell_once(AlertKind::calibration_suspect, error.what());
      show_waiting(check, "calibration", error.what(), "correct capture.calibration or its file");
      manager_.status("waiting for the camera's calibration");
    }
  } while (pause(heart_, stop_));
  return nullptr;
}

// None when told to stop.
std::optional<Shot> Beginning::first_image(capture::CameraSource& cameras, LiveCheck& check) {
  manager_.status("waiting for the camera");
  Alert fault{0, std::nullopt, AlertKind::camera_lost, "has given no image yet", "none needed"};
  while (auto captured = cameras.next(stop_)) {
    heart_.beat();
    for (const Alert& alert : captured->alerts) {
      tell(alert);
      fault = alert;
    }
    if (captured->shot) return captured->shot;
    show_waiting(check, "camera", fault.message, fault.remedy);
  }
  return std::nullopt;
}

// Once images come: by then the clock may have been set.
Config Beginning::with_variation() {
  Config config = config_;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto variation = variation_by_model(config, std::chrono::nanoseconds(now).count());
  if (!variation) return config;
  config.sensors.magnetic_variation_deg = variation->degrees;
  std::fprintf(stderr, "magnetic variation by the model: %+.1f degrees\n", variation->degrees);
  if (std::optional<Alert> alert = variation->alert) {
    alert->time = monotonic_now();
    tell(*alert);
  }
  return config;
}

// Null when told to stop.
std::unique_ptr<record::Dive> Beginning::begin_dive(capture::CameraSource& cameras,
                                                    record::Disk& disk) {
  const Time to_utc = utc_now() - monotonic_now();
  // Images are stamped by a clock that begins with the computer.
  const nlohmann::json input{{"camera", config_.capture.camera},
                             {"camera_right", config_.capture.camera_right},
                             {"utc_minus_time_s", seconds(to_utc)},
                             {"utc_is_set", clock_is_set()}};
  do {
    try {
      const auto folder = new_dive(config_.record.dives);
      record::DiveInfo info = dive_info(input, "odometry", config_);
      info.survey_files = capture::calibration_files(config_.capture);
      auto dive = std::make_unique<record::Dive>(folder, info, config_.record, disk);
      std::fprintf(stderr, "the dive: %s\n", folder.c_str());
      for (const Alert& alert : alerts_) dive->add(alert);
      return dive;
    } catch (const InputError& error) {
      tell_once(AlertKind::storage, error.what());
      manager_.status("waiting for the disk");
    }
    // What the cameras see meanwhile is not kept.
    const auto captured = cameras.next(stop_);
    for (const Alert& alert : captured ? captured->alerts : std::vector<Alert>()) tell(alert);
  } while (pause(heart_, stop_));
  return nullptr;
}

std::string in_words(const Graph& graph) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "mapping: %llu images, %.1f a second",
                static_cast<unsigned long long>(graph.shots().accepted), graph.image_rate_hz());
  return text.data();
}

Board board_of(const Load& load, Watch::Clock::time_point now, DiskForecast& forecast) {
  Board board{.battery = load.battery, .temperature_deg = load.temperature_deg};
  if (load.free_disk_gb) {
    board.free_bytes = 1e9 * *load.free_disk_gb;
    board.recording_left_s = forecast.observe(now, *board.free_bytes);
  }
  return board;
}

// Until told to stop or a stage has ended by a fault. A stage that hangs cannot be ended: the
// process has to be, and the journal is whole at any instant.
void supervise(Graph& graph, const Config& config, ServiceManager& manager, Heartbeat& heart,
               const capture::CameraSource& cameras, LiveCheck& check,
               const std::stop_token& stop) {
  Watch watch;
  Ladder ladder;
  DropRate drop_rate;
  DiskForecast forecast;
  std::mutex alone;
  std::unique_lock lock(alone);
  while (!stop.stop_requested()) {
    const auto now = Watch::Clock::now();
    if (const auto stage = watch.hung(now, graph.activities())) {
      std::fprintf(stderr, "load: the stage %s hangs; nadir starts again\n", stage->c_str());
      manager.trigger_watchdog();
      std::_Exit(1);
    }
    heart.beat(2s);  // and the watchdog's time: a diver waits 10 s at most for the map to go on
    Load load = board_load("/sys", config.record.dives);
    load.dropped = drop_rate.observe(graph.shots(), graph.stats());
    const Economy economy = ladder.observe(now, load);
    graph.economise(economy, ladder.reason(), monotonic_now());
    heart.beat(5s);
    if (const auto found = check.mapping(now, load, graph, cameras.skew())) graph.show(*found);
    Board board = board_of(load, now, forecast);
    board.exposure_ms = cameras.exposure_ms();
    if (clock_is_set()) board.utc_offset = utc_now() - monotonic_now();
    graph.note(board);
    manager.status(in_words(graph));
    std::condition_variable_any().wait_for(lock, stop, 500ms, [] { return false; });
  }
}

/// A slow card answers call by call.
class WatchedDisk : public record::Disk {
 public:
  std::int64_t write(int file, record::ByteView bytes) override {
    return noted(Disk::write(file, bytes));
  }
  int sync(int file) override { return noted(Disk::sync(file)); }
  int sync_all(int directory) override { return noted(Disk::sync_all(directory)); }

 private:
  template <class Result>
  static Result noted(Result result) {
    pipeline::note_progress();
    return result;
  }
};

// The page says what is wrong with the settings until they are right; systemd then starts anew.
int wait_for_settings(const Run& live, std::string fault, ServiceManager& manager, Heartbeat& heart,
                      const std::stop_token& stop) {
  serve::Config config;
  if (live.serve && !live.serve->host.empty()) config.address = live.serve->host;
  if (live.serve) config.port = live.serve->port;
  const auto server = open_page(config, manager);
  Publisher page(*server, "live", 0);
  manager.ready();
  manager.status("waiting for its settings");
  std::string told;
  do {
    if (std::exchange(told, fault) != fault) {
      const Alert alert{monotonic_now(), std::nullopt, AlertKind::storage, fault,
                        "correct the file; nadir begins by itself"};
      log(alert);
      page.publish(alert);
    }
    try {
      configured(live.settings, live.serve);
      return 1;
    } catch (const InputError& error) {
      fault = error.what();
    }
  } while (pause(heart, stop));
  return 0;
}

}  // namespace

int run(const Run& live) {
  ServiceManager manager;
  cv::setNumThreads(1);
  Interrupt interrupt;
  std::stop_source stop;
  interrupt.on_interrupt([stop]() mutable { stop.request_stop(); });
  const auto begun = Watch::Clock::now();
  Heartbeat heart(manager);
  Config config;
  try {
    config = configured(live.settings, live.serve);
  } catch (const InputError& error) {
    return wait_for_settings(live, error.what(), manager, heart, stop.get_token());
  }
  const auto server = open_page(config.serve, manager);
  manager.ready();
  const Recoveries recoveries(unfinished_dives(config.record.dives));
  Publisher page(*server, "live", 0, config);
  LiveCheck check(config);
  Beginning beginning(config, manager, heart, page, stop.get_token());
  const auto cameras = beginning.open_cameras(check);
  if (!cameras) return 0;
  std::optional<Shot> first = beginning.first_image(*cameras, check);
  if (!first) return 0;
  check.stop_measuring();
  const Config mapping = beginning.with_variation();
  WatchedDisk disk;
  const auto dive = beginning.begin_dive(*cameras, disk);
  if (!dive) return 0;

  Progress progress(0, stderr);
  const auto next = [&](const std::stop_token& ending) -> std::optional<capture::Captured> {
    if (first) return capture::Captured{std::exchange(first, std::nullopt), {}};
    return cameras->next(ending);
  };
  const auto note_speed = [&](double px_a_second) { cameras->note_speed(px_a_second); };
  Graph graph(mapping, {Rate::Kind::live, 0},
              {next, cameras->lasers(), note_speed, *dive, &page, progress});
  interrupt.on_interrupt([stop = graph.stop_source()]() mutable { stop.request_stop(); });
  supervise(graph, config, manager, heart, *cameras, check, graph.stop_source().get_token());
  manager.stopping();
  heart.beat(1h);  // the files of a long dive take their time; systemd's TimeoutStopSec bounds it
  return finish_dive({graph, *dive, &page, progress, begun});
}

}  // namespace nadir::app
