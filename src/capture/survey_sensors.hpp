// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The sensors' logs beside images or a video.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nadir/core/frame.hpp"
#include "sensor_log.hpp"
#include "sensor_silence.hpp"

namespace nadir::capture {

class SurveySensors {
 public:
  /// ahrs.csv, depth.csv and altitude.csv, as far as they are there. Throws InputError when one is
  /// malformed.
  explicit SurveySensors(const std::filesystem::path& folder);

  /// Rows dropped and logs without any, once; to be told with the first shot.
  std::vector<Alert> new_faults(Time time);
  /// Fills in what the logs say at frame.time.
  void read(Frame& frame, std::vector<Alert>& alerts);
  /// With the last shot.
  void finish(std::vector<Alert>& alerts);

 private:
  struct Sensor {
    std::string file;
    SensorLog log;
    SensorSilence silence;

    std::optional<SensorLog::Values> at(const Frame& frame, std::vector<Alert>& alerts);
    void finish(std::vector<Alert>& alerts);
  };
  std::optional<Sensor> load(const std::filesystem::path& file,
                             const std::vector<SensorColumn>& columns);

  std::vector<std::string> faults_;
  std::optional<Sensor> attitude_, depth_, altitude_;
};

}  // namespace nadir::capture
