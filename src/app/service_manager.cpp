// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <cstdlib>
#include <utility>

namespace nadir::app {

ServiceManager::ServiceManager() {
  constexpr int kNotForChildren = 1;
  is_there_ = std::getenv("NOTIFY_SOCKET") != nullptr;
  if (sd_listen_fds(kNotForChildren) >= 1) socket_ = SD_LISTEN_FDS_START;
}

void ServiceManager::ready() { sd_notify(0, "READY=1"); }
void ServiceManager::feed_watchdog() const { sd_notify(0, "WATCHDOG=1"); }
void ServiceManager::trigger_watchdog() { sd_notify(0, "WATCHDOG=trigger"); }
void ServiceManager::stopping() { sd_notify(0, "STOPPING=1"); }

void ServiceManager::status(const std::string& text) {
  if (std::exchange(status_, text) != text) sd_notify(0, ("STATUS=" + text).c_str());
}

}  // namespace nadir::app
