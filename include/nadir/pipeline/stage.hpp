// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Lends a thread to an algorithm: takes what comes in, calls it, measures it, and ends by closing
// what it feeds.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "nadir/core/stage_stats.hpp"
#include "nadir/pipeline/channel.hpp"
#include "nadir/pipeline/meter.hpp"
#include "nadir/pipeline/progress.hpp"

namespace nadir::pipeline {

/// One channel and what is done with each of its items.
struct Input {
  Edge* edge;
  std::function<bool()> step;  ///< processes one waiting item; false when there was none
};

/// process: void(T). It refers to the channel, which must outlive the stage.
template <class T, class Process>
Input from(Channel<T>& channel, Process process) {
  return {&channel, [&channel, process = std::move(process)]() mutable {
            std::optional<T> item = channel.take();
            if (!item) return false;
            process(*std::move(item));
            return true;
          }};
}

/// What a stage is at, to tell one that works from one that hangs.
struct StageActivity {
  std::string stage;
  /// How long the item in hand, or the wait for one to produce, has taken, from the last
  /// note_progress() on; none between items and while it waits for another stage.
  std::optional<std::chrono::nanoseconds> busy{};
  double cpu_s = 0;             ///< of its thread so far, the item in hand included
  bool neglects_input = false;  ///< items wait and it has none in hand
  bool wants_to_run = false;    ///< and would work, had it a processor
  std::uint64_t processed = 0;  ///< items so far
};

/// A named thread, from construction to join().
class Stage {
 public:
  /// Processes its inputs until all have ended; where several have items waiting, the one listed
  /// first goes first (they share one bell). Then flush (when all were drained without a fault) and
  /// close (always) are called once, on the stage's thread; close closes the stage's outputs.
  Stage(std::string name, std::vector<Input> inputs, std::function<void()> close,
        std::function<void()> flush = {});

  /// The head of the flow: calls produce until it returns false or the stage is stopped.
  Stage(std::string name, std::function<bool()> produce, std::function<void()> close);

  /// Stops and joins.
  ~Stage();

  /// "Stop now": ends after the item in hand, what waits at its inputs is lost. Any thread.
  void stop();

  /// Waits for the end; what process threw (its inputs were then abandoned, its outputs closed), or
  /// null.
  std::exception_ptr join();

  /// Any thread, at any time. Rates are means over at most the last ten seconds.
  StageStats stats() const;
  /// Any thread, at any time.
  StageActivity activity() const;

 private:
  void run(const std::function<void()>& work);
  void consume();
  bool take_one();
  void measure(Meter::Clock::time_point begin);
  void produce(const std::function<bool()>& produce_one);
  std::uint64_t arrived() const;

  const std::string name_;
  std::vector<Input> inputs_;
  const std::function<void()> close_, flush_;
  Meter meter_;
  std::exception_ptr fault_;
  std::atomic<bool> stopped_ = false;
  std::atomic<double> cpu_s_ = 0;
  Progress progress_;
  std::atomic<int> thread_id_ = 0;  ///< while it runs
  std::jthread thread_;
};

}  // namespace nadir::pipeline
