// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// From libcamera's thread to the camera's user.
#pragma once

#include <fcntl.h>
#include <libcamera/libcamera.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <optional>

#include "fault.hpp"

namespace nadir::capture::plugin {

/// Requests that are done: each is one write, which poll(2) sees.
/// Null when the camera is unplugged.
class Completed {
 public:
  Completed() {
    if (::pipe2(ends_.data(), O_CLOEXEC | O_NONBLOCK) != 0) throw Fault(failure("no pipe", errno));
  }
  ~Completed() {
    for (const int end : ends_) ::close(end);
  }
  Completed(const Completed&) = delete;
  Completed& operator=(const Completed&) = delete;

  int descriptor() const { return ends_[0]; }
  void add(libcamera::Request* request) {
    // Takes many more than there are requests.
    if (::write(ends_[1], static_cast<const void*>(&request), kSize) < 0) return;
  }
  std::optional<libcamera::Request*> take() {
    libcamera::Request* request = nullptr;
    if (::read(ends_[0], static_cast<void*>(&request), kSize) < 1) return std::nullopt;
    return request;
  }

 private:
  static constexpr std::size_t kSize = sizeof(void*);
  std::array<int, 2> ends_{-1, -1};
};

}  // namespace nadir::capture::plugin
