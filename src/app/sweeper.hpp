// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Empties folders that were taken out of sight, however long a card takes for it.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

namespace nadir::app {

class Sweeper {
 public:
  /// Of what in the folder begins with the prefix.
  Sweeper(std::filesystem::path folder, std::string prefix);
  /// Ends after the file at work; the rest waits for the next time.
  ~Sweeper() = default;

  /// There is something, or may be. Does not wait.
  void sweep();

 private:
  void work(const std::stop_token& stop);
  void remove_all(const std::stop_token& stop) const;

  const std::filesystem::path folder_;
  const std::string prefix_;
  std::mutex mutex_;
  std::condition_variable_any asked_;
  bool is_asked_ = false;
  std::jthread thread_;
};

}  // namespace nadir::app
