// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a stage's thread is at, for whoever watches it.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>

namespace nadir::pipeline {

class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  Clock::time_point begin();
  void end() { begun_ = kIdle; }
  void wait_for_another() { begun_ = kWaits; }

  /// How long the item is in hand; none between items and while waiting for another stage.
  std::optional<std::chrono::nanoseconds> busy(Clock::time_point now) const;
  bool waits_for_another() const { return begun_ == kWaits; }

  /// That of the calling thread; null unless it is a stage's.
  static Progress*& of_this_thread();

 private:
  static constexpr Clock::rep kIdle = 0, kWaits = -1;
  std::atomic<Clock::rep> begun_ = kIdle;
};

/// Of long work by many calls that each may take their time: one has come back.
void note_progress();

/// As long as it lives, the thread waits for another stage, which is to blame if that takes long.
class WaitForAnother {
 public:
  WaitForAnother();
  ~WaitForAnother();
  WaitForAnother(const WaitForAnother&) = delete;
  WaitForAnother& operator=(const WaitForAnother&) = delete;
};

}  // namespace nadir::pipeline
