// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Notices that a sensor's file says nothing of the images any more, or never did.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "nadir/core/alert.hpp"
#include "nadir/core/frame.hpp"
#include "sensor_log.hpp"

namespace nadir::capture {

class SensorSilence {
 public:
  /// Of each frame in input order, whether the log had a value at its time; last: no image follows.
  /// sensor_stale once ten images over 5 s had none, or all of a short dive; once for each such
  /// gap, and after that only for one twice as long.
  std::optional<Alert> observe(const Frame& frame, bool has_value, bool last,
                               const std::string& file, const SensorLog& log);

 private:
  std::optional<Time> last_value_;  ///< time of the last image that had one
  std::uint64_t first_image_ = 0;   ///< without a value
  Time first_time_ = 0;
  std::size_t images_ = 0;  ///< without a value, in a row
  std::size_t enough_ = 10;
  bool told_ = false;  ///< of this gap
};

}  // namespace nadir::capture
