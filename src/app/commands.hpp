// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a page tells the program to do, from the thread that answers calls to the one that does it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>

namespace nadir::app {

enum class PageCommand { begin_dive, end_dive, new_submap, shut_down };

class Commands {
 public:
  /// From now on until one was taken: a hand that presses twice gives one command.
  void accept(std::set<PageCommand> commands);

  /// False when it is not accepted now.
  bool give(PageCommand command);

  /// Waits for one; none after that time or when told to stop. By one thread.
  std::optional<PageCommand> take(const std::stop_token& stop, std::chrono::nanoseconds patience);

 private:
  std::mutex mutex_;
  std::condition_variable_any given_;
  std::set<PageCommand> accepted_;
  std::optional<PageCommand> command_;
};

}  // namespace nadir::app
