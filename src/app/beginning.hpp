// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a live dive waits for before it begins: the calibration, the camera, the disk.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

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
            LiveCheck& check, std::stop_token stop)
      : config_(config),
        manager_(manager),
        heart_(heart),
        page_(page),
        check_(check),
        stop_(std::move(stop)) {}

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

 private:
  void tell(const Alert& alert);
  void tell_once(AlertKind kind, const std::string& fault);
  void show_waiting(const std::string& item, const std::string& fault, const std::string& remedy);

  const Config& config_;
  ServiceManager& manager_;
  Heartbeat& heart_;
  Publisher& page_;
  LiveCheck& check_;
  const std::stop_token stop_;
  std::vector<Alert> alerts_;  ///< told already, to be recorded with the dive
  std::string fault_;          ///< told last
  std::filesystem::path folder_;
};

}  // namespace nadir::app
