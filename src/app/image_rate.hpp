// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How fast images come of late, and whether they do.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "drop_rate.hpp"

namespace nadir::app {

class ImageRate {
 public:
  using Clock = std::chrono::steady_clock;

  /// wanted_hz 0: any.
  explicit ImageRate(double wanted_hz);

  /// To be called once or twice a second.
  void observe(Clock::time_point now, const ImageFlow& images);

  /// Images a second, over the last ten seconds at most. None while none come, and until they have
  /// come for two seconds.
  std::optional<double> hz() const;
  /// For how long none has come, when that is longer than it should be: 3 s, or as long as three
  /// images take at the wanted rate.
  std::optional<std::chrono::seconds> silence() const;

 private:
  struct Count {
    Clock::time_point time;
    std::uint64_t images = 0;
  };
  const Clock::duration patience_;
  Clock::time_point now_{};
  std::deque<Count> counts_;  ///< at each call that found more than the one before
};

}  // namespace nadir::app
