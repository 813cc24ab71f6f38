// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a live dive waits for before it begins: the calibration, the camera, the disk, and after
// another dive a word of the diver's.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "commands.hpp"
#include "config.hpp"
#include "heartbeat.hpp"
#include "live_check.hpp"
#include "nadir/capture/camera_source.hpp"
#include "nadir/record/disk.hpp"
#include "publisher.hpp"
#include "service_manager.hpp"

namespace nadir::app {

/// Until the graph runs, its thread alone speaks to the page.
class Beginning {
 public:
  Beginning(const Config& config, ServiceManager& manager, Heartbeat& heart, Publisher& page,
            LiveCheck& check, Commands& commands, std::stop_token stop)
      : config_(config),
        manager_(manager),
        heart_(heart),
        page_(&page),
        check_(check),
        commands_(commands),
        stop_(std::move(stop)) {}

  /// Another page of an empty feed, with what was told since the last dive.
  void show_on(Publisher& page);

  // Each of these may be told to stop, or to shut down: command() then.

  /// A new board has no calibration yet. Null when told to stop.
  std::unique_ptr<capture::CameraSource> open_cameras();
  /// None when told to stop.
  std::optional<Shot> first_image(capture::CameraSource& cameras);
  /// The configuration with the magnetic variation of today. Once images come: by then the clock
  /// may have been set.
  Config with_variation();
  /// mapping: what the map will be made with. Null when told to stop.
  std::unique_ptr<record::Dive> begin_dive(const Config& mapping, capture::CameraSource& cameras,
                                           record::Disk& disk);
  /// Of the dive that was begun.
  const std::filesystem::path& folder() const { return folder_; }

  /// Between dives, until a page commands something. None when told to stop.
  std::optional<PageCommand> wait_for_command(capture::CameraSource& cameras);
  /// What ended the wait; none: the stop.
  std::optional<PageCommand> command() const { return command_; }

 private:
  bool goes_on();
  void tell(const Alert& alert);
  void tell_once(AlertKind kind, const std::string& fault);
  void show_waiting(const Finding& missing);

  const Config& config_;
  ServiceManager& manager_;
  Heartbeat& heart_;
  Publisher* page_;
  LiveCheck& check_;
  Commands& commands_;
  const std::stop_token stop_;
  std::vector<Alert> alerts_;  ///< told already, to be recorded with the dive
  std::string fault_;          ///< told last
  std::filesystem::path folder_;
  std::optional<PageCommand> command_;
};

}  // namespace nadir::app
