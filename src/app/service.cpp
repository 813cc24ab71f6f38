// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "service.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>

#include "dive_course.hpp"
#include "drop_rate.hpp"
#include "earlier_dives.hpp"
#include "nadir/core/rounded.hpp"
#include "pause.hpp"
#include "watch.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

Time utc_now() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
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

}  // namespace

Service::Service(const Config& config, ServiceManager& manager, Heartbeat& heart,
                 serve::WebServer& server, Desk& desk, std::stop_token stop)
    : config_(config),
      manager_(manager),
      heart_(heart),
      server_(server),
      desk_(desk),
      stop_(std::move(stop)),
      page_(std::in_place, server.feed(), "live", 0, config, &desk.live()),
      check_(config),
      beginning_(config, manager, heart, *page_, check_, desk.commands(), stop_) {
  desk_.live().set_controllable(true);
}

int Service::run() {
  cameras_ = beginning_.open_cameras();
  auto command = cameras_ ? map_dive() : beginning_.command();
  while (command && !stop_.stop_requested()) {
    if (command == PageCommand::shut_down) power_off();
    if (command == PageCommand::begin_dive) {
      cameras_->count_anew();
      desk_.live().prepare();
      page_.emplace(server_.begin_feed(), "live", 0, config_, &desk_.live());
      beginning_.show_on(*page_);
      command = map_dive();
    } else if (cameras_) {
      command = beginning_.wait_for_command(*cameras_);
    } else {
      cameras_ = beginning_.open_cameras();
      command = cameras_ ? std::optional(PageCommand::begin_dive) : beginning_.command();
    }
  }
  return status_;
}

// What ended it: none when told to stop, or by a fault that a file could not be made for.
std::optional<PageCommand> Service::map_dive() {
  std::optional<Shot> first = beginning_.first_image(*cameras_);
  if (!first) return beginning_.command();
  const Config mapping = beginning_.with_variation();
  WatchedDisk disk;
  const auto dive = beginning_.begin_dive(mapping, *cameras_, disk);
  if (!dive) return beginning_.command();
  desk_.live().begin(beginning_.folder());

  const auto begun = Watch::Clock::now();
  Progress progress(0, stderr);
  const auto next = [&](const std::stop_token& ending) -> std::optional<capture::Captured> {
    if (first) return capture::Captured{std::exchange(first, std::nullopt), {}};
    return cameras_->next(ending);
  };
  const auto note_speed = [this](double px_a_second) { cameras_->note_speed(px_a_second); };
  Graph graph(mapping, {Rate::Kind::live, 0},
              {next, cameras_->lasers(), note_speed, *dive, &*page_, progress, &desk_.live()});
  const std::stop_callback on_stop(stop_,
                                   [stop = graph.stop_source()]() mutable { stop.request_stop(); });
  const auto command = supervise(graph);
  graph.stop_source().request_stop();
  if (stop_.stop_requested()) manager_.stopping();
  manager_.status("making the dive's files");
  heart_.beat(1h);  // those of a long dive take their time
  try {
    status_ = finish_dive({graph, *dive, &*page_, progress, begun, &desk_.live()});
  } catch (const std::exception& fault) {
    if (command != PageCommand::shut_down) throw;  // a new start would keep the board on
    std::fprintf(stderr, "%s\n", fault.what());
    status_ = 1;
  }
  return command;
}

std::set<PageCommand> Service::accepted_while_mapping() const {
  std::set<PageCommand> accepted{PageCommand::end_dive, PageCommand::new_submap};
  if (manager_.can_power_off()) accepted.insert(PageCommand::shut_down);
  return accepted;
}

// Until told to stop, a page ends the dive or a stage has ended by a fault. A stage that hangs
// cannot be ended: the process has to be, and the journal is whole at any instant.
std::optional<PageCommand> Service::supervise(Graph& graph) {
  Watch watch;
  Ladder ladder;
  DropRate drop_rate;
  DiskForecast forecast;
  const std::stop_token over = graph.stop_source().get_token();
  while (!over.stop_requested()) {
    const auto now = Watch::Clock::now();
    if (const auto stage = watch.hung(now, graph.activities())) {
      std::fprintf(stderr, "load: the stage %s hangs; nadir starts again\n", stage->c_str());
      manager_.trigger_watchdog();
      std::_Exit(1);
    }
    heart_.beat(2s);  // and the watchdog's time: a diver waits 10 s at most for the map to go on
    Load load = board_load("/sys", config_.record.dives);
    load.dropped = drop_rate.observe(graph.shots(), graph.stats());
    const Economy economy = ladder.observe(now, load);
    graph.economise(economy, ladder.reason(), monotonic_now());
    heart_.beat(5s);
    if (const auto found = check_.mapping(now, load, graph, cameras_->skew())) graph.show(*found);
    Board board = board_of(load, now, forecast);
    board.exposure_ms = cameras_->exposure_ms();
    if (clock_is_set()) board.utc_offset = utc_now() - monotonic_now();
    graph.note(board);
    manager_.status(in_words(graph.shots(), check_.image_rate_hz()));
    desk_.commands().accept(accepted_while_mapping());
    const auto command = desk_.commands().take(over, 500ms);
    if (command == PageCommand::new_submap) {
      graph.begin_submap();
    } else if (command) {
      return command;
    }
  }
  return std::nullopt;
}

// The power may go at any instant from here on.
void Service::power_off() {
  constexpr int kPatience = 30;  // s
  const auto tell = [this](const char* message, const char* remedy) {
    const Alert alert{monotonic_now(), std::nullopt, AlertKind::storage, message, remedy};
    print(alert, stderr);
    page_->publish(alert);
  };
  const bool asked = manager_.power_off();
  manager_.status("the board powers off");
  if (asked) tell("the board powers off", "cut its power once its lights are out");
  for (int s = 0; asked && s < kPatience; ++s) {
    if (!heart_.pause(stop_)) return;
  }
  manager_.stay_on();
  tell("the board did not power off",
       status_ == 0 ? "cut its power: all is on the disk"
                    : "cut its power: what files the dive lacks are made at the next start");
}

}  // namespace nadir::app
