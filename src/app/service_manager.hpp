// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What systemd and this service tell each other: sd_notify(3), sd_listen_fds(3). Without systemd
// nothing is told.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace nadir::app {

/// Made before other threads, since it changes the environment.
class ServiceManager {
 public:
  ServiceManager();

  /// Whether there is one that starts this program again when it ends.
  bool is_there() const { return is_there_; }
  /// The socket that nadir.socket listens on.
  std::optional<int> socket() const { return socket_; }

  /// Whether the board can be asked to power itself off: systemd's nadir-poweroff.path waits for
  /// it.
  bool can_power_off() const { return power_off_request_.has_value(); }
  /// False when it could not even be asked. The request stands until taken back.
  bool power_off() const;
  void stay_on() const;

  void ready();
  /// What `systemctl status` shows; told only when it has changed.
  void status(const std::string& text);
  /// Is alive: expected every few seconds. Any thread.
  void feed_watchdog() const;
  /// Hangs: to be killed and started again at once.
  void trigger_watchdog();
  void stopping();

 private:
  bool is_there_ = false;
  std::optional<int> socket_;
  std::optional<std::filesystem::path> power_off_request_;
  std::string status_;
};

}  // namespace nadir::app
