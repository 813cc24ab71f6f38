// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The last items of a stage: how long each took and when. Written by one thread, read by any,
// without locks.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>

namespace nadir::pipeline {

class Meter {
 public:
  using Clock = std::chrono::steady_clock;

  /// arrived: items that had come to the stage's door by then, dropped ones included.
  void add(Clock::time_point begin, Clock::time_point end, std::uint64_t arrived);

  struct Reading {
    std::uint64_t count = 0;  ///< items since the start
    double rate_in_hz = 0, rate_out_hz = 0;
    double last_ms = 0, p95_ms = 0;
  };
  /// Over the last kSpan or kSize items, whichever is shorter; rates are 0 before the second item.
  Reading read(Clock::time_point now, std::uint64_t arrived) const;

 private:
  struct Sample {
    std::atomic<std::int64_t> end_ns = 0, duration_ns = 0;
    std::atomic<std::uint64_t> arrived = 0;
  };
  static constexpr std::uint64_t kSize = 128;
  static constexpr std::chrono::seconds kSpan{10};

  std::array<Sample, kSize> samples_;
  std::atomic<std::uint64_t> begun_ = 0, done_ = 0;
};

}  // namespace nadir::pipeline
