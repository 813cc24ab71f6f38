// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Feeds the service manager's watchdog as long as the main thread gives signs of life, which may
// wait for a device longer than the watchdog does.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "service_manager.hpp"

namespace nadir::app {

class Heartbeat {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Heartbeat(const ServiceManager& manager);
  /// By the main thread: the next will come within that time.
  void beat(Clock::duration within = std::chrono::seconds(10)) {
    until_ = (Clock::now() + within).time_since_epoch().count();
  }
  /// By the main thread: beats and waits a second. False when told to stop.
  bool pause(const std::stop_token& stop);

 private:
  std::atomic<Clock::rep> until_ = 0;
  std::jthread thread_;
};

}  // namespace nadir::app
