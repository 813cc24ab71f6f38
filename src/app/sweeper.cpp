// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sweeper.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>
#include <vector>

namespace nadir::app {

namespace fs = std::filesystem;

Sweeper::Sweeper(fs::path folder, std::string prefix)
    : folder_(std::move(folder)), prefix_(std::move(prefix)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

void Sweeper::sweep() {
  {
    const std::scoped_lock lock(mutex_);
    is_asked_ = true;
  }
  asked_.notify_one();
}

void Sweeper::work(const std::stop_token& stop) {
  constexpr int kLowest = 19;
  pthread_setname_np(pthread_self(), "sweeper");
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowest);
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      asked_.wait(lock, stop, [this] { return is_asked_; });
      is_asked_ = false;
    }
    if (stop.stop_requested()) return;
    remove_all(stop);
  }
}

// File by file, so that the end of the program need not wait for thousands.
void Sweeper::remove_all(const std::stop_token& stop) const {
  std::error_code error;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    if (entry.path().filename().string().starts_with(prefix_)) left.push_back(entry.path());
  }
  for (const fs::path& folder : left) {
    for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
      if (stop.stop_requested()) return;
      if (entry.is_symlink(error) || !entry.is_directory(error)) fs::remove(entry.path(), error);
    }
    fs::remove_all(folder, error);
  }
}

}  // namespace nadir::app
