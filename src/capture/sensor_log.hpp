// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A sensor's recorded values, interpolated at the times of images.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nadir/core/time.hpp"

namespace nadir::capture {

/// Up to three values per row; an angle in degrees is interpolated the short way round.
struct SensorColumn {
  std::string name;
  double lowest = 0, highest = 0;  ///< rows outside are dropped
  bool angle = false;
};

class SensorLog {
 public:
  using Values = std::array<double, 3>;

  SensorLog() = default;
  /// Reads FILE: seconds and the columns. Rows that are not finite or out of range, and all but the
  /// first of one time, are dropped and counted. Throws InputError when malformed.
  SensorLog(const std::filesystem::path& file, std::vector<SensorColumn> columns);

  /// Linear between the rows around it; none where they lie more than 0.5 s apart, or outside them.
  /// Angles within [-180, 180).
  std::optional<Values> at(Time time) const;
  /// Times of the first and the last row; needs a row.
  std::pair<Time, Time> span() const { return {rows_.front().time, rows_.back().time}; }
  std::size_t size() const { return rows_.size(); }
  std::size_t dropped() const { return dropped_; }

 private:
  struct Row {
    Time time = 0;
    Values values{};
  };

  std::vector<SensorColumn> columns_;
  std::vector<Row> rows_;  ///< by time
  std::size_t dropped_ = 0;
};

}  // namespace nadir::capture
