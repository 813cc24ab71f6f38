// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <utility>

namespace nadir::app {

void Commands::accept(std::set<PageCommand> commands) {
  const std::scoped_lock lock(mutex_);
  accepted_ = std::move(commands);
  if (command_ && !accepted_.contains(*command_)) command_.reset();
}

bool Commands::give(PageCommand command) {
  {
    const std::scoped_lock lock(mutex_);
    if (command_ || !accepted_.contains(command)) return false;
    command_ = command;
  }
  given_.notify_one();
  return true;
}

std::optional<PageCommand> Commands::take(const std::stop_token& stop,
                                          std::chrono::nanoseconds patience) {
  std::unique_lock lock(mutex_);
  given_.wait_for(lock, stop, patience, [this] { return command_.has_value(); });
  if (command_) accepted_.clear();
  return std::exchange(command_, std::nullopt);
}

}  // namespace nadir::app
