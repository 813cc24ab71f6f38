// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and termination as an event: the first asks the machine to end in good order.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

namespace nadir::app {

/// Made before any other thread, so that all of them inherit the blocked signals and this one alone
/// receives them.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();

  /// Called once, on this object's thread, at the first SIGINT, SIGTERM or SIGHUP; at once when it
  /// has come already.
  void on_interrupt(std::function<void()> action);
  bool received() const { return received_.load(); }
  /// Blocks until the signal comes.
  void wait() const { received_.wait(false); }

 private:
  void listen();

  std::atomic<bool> received_ = false, ending_ = false;
  std::atomic<std::shared_ptr<const std::function<void()>>> action_;
  std::jthread thread_;
};

}  // namespace nadir::app
