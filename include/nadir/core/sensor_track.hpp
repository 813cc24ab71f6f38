// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A sensor's values over time, interpolated at the times of images.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "nadir/core/time.hpp"

namespace nadir {

class SensorTrack {
 public:
  using Values = std::array<double, 3>;
  struct Row {
    Time time = 0;
    Values values{};
  };

  /// periods: of values that are angles, a full turn in their unit; 0 for others.
  explicit SensorTrack(const Values& periods = {}) : periods_(periods) {}

  /// False, and left out, when it is not later than the newest.
  bool add(Time time, const Values& values);

  /// Linear between the rows around it, angles the short way round and within half a turn of 0.
  /// None where the rows lie more than 0.5 s apart, and outside them.
  std::optional<Values> at(Time time) const;

  void forget_before(Time time);

  const std::deque<Row>& rows() const { return rows_; }  ///< by time

 private:
  Values periods_;
  std::deque<Row> rows_;
};

}  // namespace nadir
