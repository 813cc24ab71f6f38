// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Tells a stage that hangs from one that works long or has nothing to do.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nadir/pipeline/stage.hpp"

namespace nadir::app {

class Watch {
 public:
  using Clock = std::chrono::steady_clock;

  /// To be called once or twice a second. The stage that hangs: that has had an item in hand for
  /// 4 s (recorder and capture: 6 s) without using the processor or waiting for it, or for a minute
  /// whatever it does, or takes none of those that wait for 4 s.
  std::optional<std::string> hung(Clock::time_point now,
                                  const std::vector<pipeline::StageActivity>& activities);

 private:
  struct Sample {
    Clock::time_point time;
    double cpu_s = 0;
  };
  struct Neglect {
    Clock::time_point since;
    std::uint64_t processed = 0;
  };
  bool is_blocked(Clock::time_point now, const pipeline::StageActivity& activity);
  bool sleeps(Clock::time_point now, const pipeline::StageActivity& activity);

  std::map<std::string, std::deque<Sample>> samples_;  ///< of each stage's item in hand
  std::map<std::string, Neglect> neglects_;            ///< of the items that wait
};

}  // namespace nadir::app
