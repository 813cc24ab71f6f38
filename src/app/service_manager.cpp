// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <cstdlib>
#include <fstream>
#include <system_error>
#include <utility>

namespace nadir::app {

ServiceManager::ServiceManager() {
  constexpr int kNotForChildren = 1;
  is_there_ = std::getenv("NOTIFY_SOCKET") != nullptr;
  if (const char* const own = std::getenv("RUNTIME_DIRECTORY"))
    power_off_request_ = std::filesystem::path(own) / "power-off";
  if (sd_listen_fds(kNotForChildren) >= 1) socket_ = SD_LISTEN_FDS_START;
}

bool ServiceManager::power_off() const {
  return power_off_request_ && std::ofstream(*power_off_request_).is_open();
}

void ServiceManager::stay_on() const {
  std::error_code ignored;
  if (power_off_request_) std::filesystem::remove(*power_off_request_, ignored);
}

void ServiceManager::ready() { sd_notify(0, "READY=1"); }
void ServiceManager::feed_watchdog() const { sd_notify(0, "WATCHDOG=1"); }
void ServiceManager::trigger_watchdog() { sd_notify(0, "WATCHDOG=trigger"); }
void ServiceManager::stopping() { sd_notify(0, "STOPPING=1"); }

void ServiceManager::status(const std::string& text) {
  if (std::exchange(status_, text) != text) sd_notify(0, ("STATUS=" + text).c_str());
}

}  // namespace nadir::app
