// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "heartbeat.hpp"

#include <pthread.h>

#include "pause.hpp"

namespace nadir::app {

Heartbeat::Heartbeat(const ServiceManager& manager) {
  using namespace std::chrono_literals;
  beat();
  thread_ = std::jthread([this, &manager](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "heartbeat");
    do {
      if (Clock::now().time_since_epoch().count() < until_) manager.feed_watchdog();
    } while (pause_for(1s, stop));
  });
}

bool Heartbeat::pause(const std::stop_token& stop) {
  beat();
  return pause_for(std::chrono::seconds(1), stop);
}

}  // namespace nadir::app
