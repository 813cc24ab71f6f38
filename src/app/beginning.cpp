// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "beginning.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "dive_course.hpp"
#include "earlier_dives.hpp"
#include "nadir/core/check.hpp"
#include "variation.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

record::DiveInfo info_of(const Config& mapping) {
  const Time to_utc =
      std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count() -
      monotonic_now();
  // Images are stamped by a clock that begins with the computer.
  const nlohmann::json input{{"camera", mapping.capture.camera},
                             {"camera_right", mapping.capture.camera_right},
                             {"utc_minus_time_s", seconds(to_utc)},
                             {"utc_is_set", clock_is_set()}};
  record::DiveInfo info = dive_info(input, "odometry", mapping);
  info.survey_files = capture::calibration_files(mapping.capture);
  return info;
}

// Every try has a name of its own, with the time in it, and the fault is told once.
std::string of_any_dive(std::string fault, const std::filesystem::path& folder) {
  const std::string name = '/' + folder.filename().string();
  if (const auto at = fault.find(name); at != fault.npos) fault.erase(at, name.size());
  return fault;
}

}  // namespace

void Beginning::show_on(Publisher& page) {
  page_ = &page;
  for (const Alert& alert : alerts_) page_->publish(alert);
}

// False when told to stop or to shut down.
bool Beginning::goes_on() {
  if (manager_.can_power_off()) commands_.accept({PageCommand::shut_down});
  command_ = commands_.take(stop_, 0s);
  return !command_ && !stop_.stop_requested();
}

void Beginning::tell(const Alert& alert) {
  print(alert, stderr);
  page_->publish(alert);
  constexpr std::size_t kMost = 1000;
  if (alerts_.size() < kMost) alerts_.push_back(alert);
}

void Beginning::tell_once(AlertKind kind, const std::string& fault) {
  if (std::exchange(fault_, fault) == fault) return;
  tell({monotonic_now(), std::nullopt, kind, fault,
        "mapping begins by itself as soon as that is mended"});
}

void Beginning::show_waiting(const Finding& missing) {
  const Load load = board_load("/sys", config_.record.dives);
  if (const auto found = check_.waiting(LiveCheck::Clock::now(), load, missing))
    page_->publish(*found);
}

std::unique_ptr<capture::CameraSource> Beginning::open_cameras() {
  do {
    try {
      const bool keep = config_.record.originals != record::Originals::none;
      return std::make_unique<capture::CameraSource>(config_.capture, keep);
    } catch (const InputError& error) {
      tell_once(AlertKind::calibration_suspect, error.what());
      show_waiting(
          {Verdict::bad, "calibration", error.what(), "correct capture.calibration or its file"});
      manager_.status("waiting for the camera's calibration");
    }
  } while (heart_.pause(stop_) && goes_on());
  return nullptr;
}

std::optional<Shot> Beginning::first_image(capture::CameraSource& cameras) {
  manager_.status("waiting for the camera");
  Alert fault{0, std::nullopt, AlertKind::camera_lost, "has given no image yet", "none needed"};
  while (goes_on()) {
    auto captured = cameras.next(stop_);
    if (!captured) break;
    heart_.beat();
    for (const Alert& alert : captured->alerts) {
      tell(alert);
      fault = alert;
    }
    if (captured->shot) return captured->shot;
    show_waiting({Verdict::bad, "camera", fault.message, fault.remedy});
  }
  return std::nullopt;
}

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

std::unique_ptr<record::Dive> Beginning::begin_dive(const Config& mapping,
                                                    capture::CameraSource& cameras,
                                                    record::Disk& disk) {
  check_.stop_measuring();
  bool failed = false;
  do {
    heart_.beat(2min);  // for some dozen calls of a slow card
    const std::filesystem::path folder = new_dive(config_.record.dives);
    try {
      auto dive = std::make_unique<record::Dive>(folder, info_of(mapping), mapping.record, disk);
      folder_ = folder;
      std::fprintf(stderr, "the dive: %s\n", folder.c_str());
      if (failed) {
        tell({monotonic_now(), std::nullopt, AlertKind::storage_back, "the disk takes the dive",
              "none needed"});
      }
      dive->add(std::exchange(alerts_, {}));
      fault_.clear();
      return dive;
    } catch (const InputError& error) {
      failed = true;
      const std::string fault = of_any_dive(error.what(), folder);
      tell_once(AlertKind::storage, fault);
      show_waiting({Verdict::bad, "disk", fault, "check the disk, its mount and record.dives"});
      manager_.status("waiting for the disk");
    }
    // What the cameras see meanwhile is not kept.
    const auto captured = cameras.next(stop_);
    for (const Alert& alert : captured ? captured->alerts : std::vector<Alert>()) tell(alert);
  } while (heart_.pause(stop_) && goes_on());
  return nullptr;
}

std::optional<PageCommand> Beginning::wait_for_command(capture::CameraSource& cameras) {
  manager_.status("waiting for a dive to be begun");
  std::set<PageCommand> accepted{PageCommand::begin_dive};
  if (manager_.can_power_off()) accepted.insert(PageCommand::shut_down);
  commands_.accept(std::move(accepted));
  while (const auto captured = cameras.next(stop_)) {  // what they see is not kept
    heart_.beat();
    for (const Alert& alert : captured->alerts) tell(alert);
    if (const auto command = commands_.take(stop_, 0s)) return command;
    show_waiting({Verdict::absent, "dive", "none is being recorded", "begin one: Menu, Dive"});
  }
  return std::nullopt;
}

}  // namespace nadir::app
