// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sweeper.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

#include "nadir/core/entries.hpp"

namespace nadir::app {

namespace fs = std::filesystem;

namespace {

/// File by file, so that the end of the program need not wait for thousands. What cannot be removed
/// stays, and so do the folders it is in.
void remove(const fs::path& path, const std::stop_token& stop) {
  std::error_code fault;
  if (fs::symlink_status(path, fault).type() == fs::file_type::directory) {
    for (const fs::path& entry : entries_of(path)) remove(entry, stop);
  }
  if (!stop.stop_requested()) fs::remove(path, fault);
}

}  // namespace

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

void Sweeper::remove_all(const std::stop_token& stop) const {
  for (const fs::path& path : entries_of(folder_)) {
    if (path.filename().string().starts_with(prefix_)) remove(path, stop);
  }
}

}  // namespace nadir::app
