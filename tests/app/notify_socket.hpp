// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A service manager's end of sd_notify(3).
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <vector>

namespace nadir::app {

/// As long as it lives, what this process tells its service manager comes here.
class NotifySocket {
 public:
  NotifySocket() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const std::string name = "@nadir-test-" + std::to_string(getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::ranges::copy(name, address.sun_path);
    address.sun_path[0] = '\0';
    bound_ = ::bind(socket_, reinterpret_cast<const sockaddr*>(&address),
                    static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size())) == 0;
    ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~NotifySocket() {
    ::unsetenv("NOTIFY_SOCKET");
    ::close(socket_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  bool bound() const { return bound_; }

  /// What has come by now.
  std::vector<std::string> told() const {
    std::vector<std::string> all;
    while (is_readable(0)) all.push_back(next());
    return all;
  }
  /// Whether it comes soon.
  bool hears(const std::string& text) const {
    constexpr int kPatience_ms = 5000;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatience_ms);
    while (std::chrono::steady_clock::now() < end && is_readable(kPatience_ms)) {
      if (next() == text) return true;
    }
    return false;
  }

 private:
  bool is_readable(int patience_ms) const {
    pollfd waiting{socket_, POLLIN, 0};
    return ::poll(&waiting, 1, patience_ms) > 0;
  }
  std::string next() const {
    std::string text(4096, '\0');
    const ssize_t size = ::recv(socket_, text.data(), text.size(), 0);
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }

  int socket_;
  bool bound_ = false;
};

}  // namespace nadir::app
