// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A sensor's recorded values, interpolated at the times of images.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nadir/core/sensor_track.hpp"

namespace nadir::capture {

/// Up to three values per row; an angle in degrees is interpolated the short way round.
struct SensorColumn {
  std::string name;
  double lowest = 0, highest = 0;  ///< rows outside are dropped
  bool angle = false;
};

class SensorLog {
 public:
  using Values = SensorTrack::Values;

  SensorLog() = default;
  /// Reads FILE: seconds and the columns. Rows that are not finite or out of range, and all but the
  /// first of one time, are dropped and counted. Throws InputError when malformed.
  SensorLog(const std::filesystem::path& file, const std::vector<SensorColumn>& columns);

  /// As SensorTrack; angles within [-180, 180).
  std::optional<Values> at(Time time) const { return track_.at(time); }
  /// Times of the first and the last row; needs a row.
  std::pair<Time, Time> span() const {
    return {track_.rows().front().time, track_.rows().back().time};
  }
  std::size_t size() const { return track_.rows().size(); }
  std::size_t dropped() const { return dropped_; }

 private:
  SensorTrack track_;
  std::size_t dropped_ = 0;
};

}  // namespace nadir::capture
