// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "board.hpp"

namespace nadir::app {

using namespace std::chrono_literals;

std::optional<double> DiskForecast::observe(Clock::time_point now, double free_bytes) {
  constexpr auto kStep = 5s, kBegin = 30s, kMemory = 300s;
  if (past_.empty() || now - past_.back().when >= kStep) past_.push_back({now, free_bytes});
  while (past_.size() > 1 && now - past_[1].when >= kMemory) past_.pop_front();
  const Then& then = past_.front();
  const double elapsed = std::chrono::duration<double>(now - then.when).count();
  const double filled = then.free_bytes - free_bytes;
  if (now - then.when < kBegin || !(filled > 0)) return std::nullopt;
  return free_bytes * elapsed / filled;
}

}  // namespace nadir::app
