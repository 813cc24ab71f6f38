// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Waits that end at once when told to stop.
#pragma once

#include <chrono>
#include <stop_token>

namespace nadir::app {

/// False when told to stop.
bool pause_until(std::chrono::steady_clock::time_point end, const std::stop_token& stop);

inline bool pause_for(std::chrono::nanoseconds time, const std::stop_token& stop) {
  return pause_until(std::chrono::steady_clock::now() + time, stop);
}

}  // namespace nadir::app
