// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "worker.hpp"

#include <pthread.h>

#include <utility>

namespace nadir::serve {

void Worker::post(std::function<void()> job) {
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  has_work_.notify_one();
}

void Worker::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  jobs_.clear();  // what they hold may not outlive what they were to answer
}

void Worker::work(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "calls");
  std::unique_lock lock(mutex_);
  while (has_work_.wait(lock, stop, [this] { return !jobs_.empty(); })) {
    if (stop.stop_requested()) return;
    const std::function<void()> job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
}

}  // namespace nadir::serve
