// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a person at a terminal sees of a replay: one line that is rewritten, or plain lines in a
// log.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <set>

#include "nadir/record/dive.hpp"

namespace nadir::app {

/// One line: kind, what happened, what to do.
void print(const Alert& alert, std::FILE* out);

class Progress {
 public:
  /// total: images expected, 0: unknown; out is asked whether it is a terminal.
  Progress(std::size_t total, std::FILE* out);

  void add(const record::Entry& entry);
  void add(const Alert& alert);
  /// Ends the rewritten line.
  void finish();

 private:
  void show(bool now);
  void clear_line();

  using Clock = std::chrono::steady_clock;
  const std::size_t total_;
  std::FILE* const out_;
  const bool terminal_;
  const Clock::time_point begun_ = Clock::now();
  Clock::time_point shown_ = begun_;
  std::uint64_t captured_ = 0, oriented_ = 0, lost_ = 0, planes_ = 0;
  TrackingState state_ = TrackingState::waiting;
  std::set<std::uint64_t> seen_;  ///< images with a pose
};

}  // namespace nadir::app
