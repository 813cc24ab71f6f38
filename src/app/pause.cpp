// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pause.hpp"

#include <condition_variable>
#include <mutex>

namespace nadir::app {

bool pause_until(std::chrono::steady_clock::time_point end, const std::stop_token& stop) {
  std::mutex alone;
  std::unique_lock lock(alone);
  std::condition_variable_any().wait_until(lock, stop, end, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace nadir::app
