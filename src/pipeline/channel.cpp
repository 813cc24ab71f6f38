// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/channel.hpp"

#include "nadir/core/check.hpp"
#include "nadir/pipeline/progress.hpp"

namespace nadir::pipeline {

Edge::Edge(std::size_t capacity, WhenFull when_full, std::shared_ptr<Bell> bell)
    : room_(static_cast<Bell::ssize_t>(capacity)), bell_(std::move(bell)), when_full_(when_full) {
  NADIR_CHECK(capacity > 0);
}

void Edge::close() {
  if (!closed_.exchange(true, std::memory_order_release)) bell_->signal();
}

void Edge::abandon() {
  if (abandoned_.exchange(true, std::memory_order_release)) return;
  // One token more than the ring has places: whoever gets it has seen the flag, and leaves.
  room_.signal();
  bell_->signal();
}

bool Edge::ended() const {
  if (abandoned_.load(std::memory_order_acquire)) return true;
  return closed_.load(std::memory_order_acquire) && depth() == 0;
}

std::size_t Edge::depth() const {
  // popped first: it never passes pushed.
  const std::uint64_t popped = popped_.load(std::memory_order_acquire);
  return static_cast<std::size_t>(pushed_.load(std::memory_order_acquire) - popped);
}

std::uint64_t Edge::dropped() const { return dropped_.load(std::memory_order_relaxed); }

std::uint64_t Edge::accepted() const { return pushed_.load(std::memory_order_relaxed); }

bool Edge::reserve() {
  NADIR_CHECK(!closed_.load(std::memory_order_relaxed));
  if (abandoned_.load(std::memory_order_acquire)) return false;
  if (when_full_ == WhenFull::wait) {
    if (!room_.tryWait()) {
      const WaitForAnother reader;
      room_.wait();
    }
  } else if (!room_.tryWait()) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  return !abandoned_.load(std::memory_order_acquire);
}

}  // namespace nadir::pipeline
