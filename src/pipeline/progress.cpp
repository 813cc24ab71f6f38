// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/progress.hpp"

namespace nadir::pipeline {

Progress*& Progress::of_this_thread() {
  thread_local Progress* own = nullptr;
  return own;
}

Progress::Clock::time_point Progress::begin() {
  const auto now = Clock::now();
  begun_ = now.time_since_epoch().count();
  return now;
}

std::optional<std::chrono::nanoseconds> Progress::busy(Clock::time_point now) const {
  const Clock::rep begun = begun_;
  if (begun == kIdle || begun == kWaits) return std::nullopt;
  return now.time_since_epoch() - Clock::duration(begun);
}

void note_progress() {
  if (Progress* const own = Progress::of_this_thread()) own->begin();
}

WaitForAnother::WaitForAnother() {
  if (Progress* const own = Progress::of_this_thread()) own->wait_for_another();
}

WaitForAnother::~WaitForAnother() { note_progress(); }

}  // namespace nadir::pipeline
