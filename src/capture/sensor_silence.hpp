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
  /// Of each frame in input order, whether the log had a value at its time. sensor_stale once ten
  /// images over 5 s had none; once for each such gap, and after that only for one twice as long.
  std::optional<Alert> observe(const Frame& frame, bool has_value, const std::string& file,
                               const SensorLog& log);

  /// After the last image, whether it was read or not: sensor_stale when no frame at all had a
  /// value and that was not told yet.
  std::optional<Alert> finish(const std::string& file, const SensorLog& log);

 private:
  Alert tell(const std::string& file, const SensorLog& log);

  std::optional<Time> last_value_;  ///< time of the last image that had one
  std::uint64_t first_image_ = 0;   ///< without a value
  Time first_time_ = 0;
  std::uint64_t newest_image_ = 0;
  Time newest_time_ = 0;
  std::size_t images_ = 0;  ///< without a value, in a row
  std::size_t enough_ = 10;
  bool told_ = false;  ///< of this gap
};

}  // namespace nadir::capture
