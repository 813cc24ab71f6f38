// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The live service: waits for what is missing, maps, and tells the service manager that it lives.
#include <chrono>
#include <cstdio>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string>
#include <utility>

#include "beginning.hpp"
#include "configured.hpp"
#include "desk.hpp"
#include "device_token.hpp"
#include "dive_course.hpp"
#include "drop_rate.hpp"
#include "earlier_dives.hpp"
#include "heartbeat.hpp"
#include "interrupt.hpp"
#include "live_check.hpp"
#include "nadir/core/check.hpp"
#include "nadir/core/rounded.hpp"
#include "page_assets.hpp"
#include "pause.hpp"
#include "service_manager.hpp"
#include "verbs.hpp"
#include "watch.hpp"
#include "watched_disk.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

Time utc_now() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

// What nadir.socket was made of must not keep a dive from being recorded.
std::unique_ptr<serve::WebServer> open_page(const serve::Config& config,
                                            const ServiceManager& manager,
                                            const serve::Handlers& handlers) {
  std::unique_ptr<serve::WebServer> server;
  try {
    server = std::make_unique<serve::WebServer>(config, page_assets(), manager.socket(),
                                                serve::Listen::in_time, handlers);
  } catch (const InputError& error) {
    if (!manager.socket()) throw;
    std::fprintf(stderr, "%s\n", error.what());
    server = std::make_unique<serve::WebServer>(config, page_assets(), std::nullopt,
                                                serve::Listen::in_time, handlers);
  }
  if (server->port() != 0) {
    std::fprintf(stderr, "the map: %s\n", page_url(config.address, server->port()).c_str());
  } else {
    std::fprintf(stderr, "%s; it is tried every second\n", server->listen_fault().c_str());
  }
  return server;
}

std::string token_of(const Config& config) {
  const DeviceToken token = device_token(token_file(config.record.dives), record::system_disk());
  if (!token.message.empty()) std::fprintf(stderr, "%s\n", token.message.c_str());
  return token.token;
}

std::string in_words(const ImageFlow& images, std::optional<double> rate_hz) {
  return "mapping: " + std::to_string(images.accepted) + " images" +
         (rate_hz ? ", " + rounded(*rate_hz) + " a second" : "");
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
  do {
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
    manager.status(in_words(graph.shots(), check.image_rate_hz()));
  } while (pause_for(500ms, stop));
}

// The page says what is wrong with the settings until they are right; the service manager then
// starts it again.
int wait_for_settings(const Run& live, std::string fault, ServiceManager& manager, Heartbeat& heart,
                      const std::stop_token& stop) {
  serve::Config config;
  if (live.serve && !live.serve->host.empty()) config.address = live.serve->host;
  if (live.serve) config.port = live.serve->port;
  const auto server = open_page(config, manager, {});
  Publisher page(server->feed(), "live", 0);
  manager.ready();
  manager.status("waiting for its settings");
  std::string told;
  do {
    if (std::exchange(told, fault) != fault) {
      const Alert alert{monotonic_now(), std::nullopt, AlertKind::storage, fault,
                        "correct the file; nadir begins by itself"};
      print(alert, stderr);
      page.publish(alert);
    }
    try {
      configured(live.settings, live.serve);
      std::fprintf(stderr, "the settings are right; nadir starts again\n");
      return 1;
    } catch (const InputError& error) {
      fault = error.what();
    }
  } while (heart.pause(stop));
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
    if (!manager.is_there()) throw;
    return wait_for_settings(live, error.what(), manager, heart, stop.get_token());
  }
  Desk desk(config.record.dives, token_of(config), url_for_others(config.serve));
  const auto server = open_page(config.serve, manager, desk.handlers());
  desk.serve_by(*server, config.serve.retained_bytes);
  manager.ready();
  const Recoveries recoveries(unfinished_dives(config.record.dives));
  Publisher page(server->feed(), "live", 0, config, &desk.live());
  LiveCheck check(config);
  Beginning beginning(config, manager, heart, page, check, stop.get_token());
  const auto cameras = beginning.open_cameras();
  if (!cameras) return 0;
  std::optional<Shot> first = beginning.first_image(*cameras);
  if (!first) return 0;
  const Config mapping = beginning.with_variation();
  WatchedDisk disk;
  const auto dive = beginning.begin_dive(mapping, *cameras, disk);
  if (!dive) return 0;
  desk.live().begin(beginning.folder());

  Progress progress(0, stderr);
  const auto next = [&](const std::stop_token& ending) -> std::optional<capture::Captured> {
    if (first) return capture::Captured{std::exchange(first, std::nullopt), {}};
    return cameras->next(ending);
  };
  const auto note_speed = [&](double px_a_second) { cameras->note_speed(px_a_second); };
  Graph graph(mapping, {Rate::Kind::live, 0},
              {next, cameras->lasers(), note_speed, *dive, &page, progress, &desk.live()});
  interrupt.on_interrupt([stop = graph.stop_source()]() mutable { stop.request_stop(); });
  supervise(graph, config, manager, heart, *cameras, check, graph.stop_source().get_token());
  manager.stopping();
  heart.beat(1h);  // the files of a long dive take their time; systemd's TimeoutStopSec bounds it
  return finish_dive({graph, *dive, &page, progress, begun, &desk.live()});
}

}  // namespace nadir::app
