// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the live service knows of its board and cameras, for the page. Unknown is none.
#pragma once

#include <chrono>
#include <deque>
#include <optional>

#include "nadir/core/time.hpp"

namespace nadir::app {

struct Board {
  std::optional<double> battery{};  ///< left, of full
  std::optional<double> temperature_deg{};
  std::optional<double> free_bytes{};        ///< of the dives' disk
  std::optional<double> recording_left_s{};  ///< until it is full
  std::optional<double> exposure_ms{};       ///< of the cameras
  std::optional<Time> utc_offset{};          ///< UTC minus the clock of the images
};

/// How long a disk lasts that fills as it did of late.
class DiskForecast {
 public:
  using Clock = std::chrono::steady_clock;

  /// Seconds; none before half a minute, and while the disk does not fill.
  std::optional<double> observe(Clock::time_point now, double free_bytes);

 private:
  struct Then {
    Clock::time_point when;
    double free_bytes = 0;
  };
  std::deque<Then> past_;
};

}  // namespace nadir::app
