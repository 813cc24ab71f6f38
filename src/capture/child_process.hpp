// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A program of its own process, whose output is read while it runs.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace nadir::capture {

class ChildProcess {
 public:
  /// command: the program, searched for in PATH, and its arguments; no shell sees them. Throws
  /// InputError naming the fault when it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& command);
  /// Kills it when it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Fills bytes with its output. False when it ended before, or said nothing for so long.
  bool read(std::span<std::uint8_t> bytes, std::chrono::milliseconds patience);
  /// The next line of its error output; none when there is none yet.
  std::optional<std::string> next_line();
  /// Kills it when it still runs. Its exit status; none when it was killed.
  std::optional<int> end();

 private:
  bool fill_lines();

  pid_t process_ = -1;
  int output_ = -1, errors_ = -1;
  std::string partial_line_;
  std::deque<std::string> lines_;
};

}  // namespace nadir::capture
