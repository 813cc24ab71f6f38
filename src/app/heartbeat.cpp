// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "heartbeat.hpp"

#include <pthread.h>

#include <condition_variable>
#include <mutex>

namespace nadir::app {

Heartbeat::Heartbeat(const ServiceManager& manager) {
  using namespace std::chrono_literals;
  beat();
  thread_ = std::jthread([this, &manager](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "heartbeat");
    std::mutex alone;
    std::unique_lock lock(alone);
    while (!stop.stop_requested()) {
      if (Clock::now().time_since_epoch().count() < until_) manager.feed_watchdog();
      std::condition_variable_any().wait_for(lock, stop, 1s, [] { return false; });
    }
  });
}

}  // namespace nadir::app
