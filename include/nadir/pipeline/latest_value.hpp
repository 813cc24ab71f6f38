// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One slot where the newest value wins: for what is worthless once superseded, as a live image.
#pragma once

#include <readerwriterqueue/atomicops.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

namespace nadir::pipeline {

/// One producer, one consumer, no locks. Both must have ended before it is destroyed.
template <class T>
class LatestValue {
 public:
  LatestValue() = default;
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;
  ~LatestValue() { delete slot_.load(std::memory_order_acquire); }

  void publish(T value) {
    auto fresh = std::make_unique<T>(std::move(value));
    const std::unique_ptr<T> old(slot_.exchange(fresh.release(), std::memory_order_acq_rel));
    if (old) {
      superseded_.fetch_add(1, std::memory_order_relaxed);
    } else {
      full_.signal();
    }
  }

  /// Waits for a value not taken yet; none when closed and taken.
  std::optional<T> take() {
    full_.wait();
    std::optional<T> value = empty_slot();
    if (!value) full_.signal();
    return value;
  }

  /// None when there is nothing new.
  std::optional<T> try_take() {
    if (!full_.tryWait()) return std::nullopt;
    std::optional<T> value = empty_slot();
    if (!value) full_.signal();
    return value;
  }

  /// By the producer, once, after its last value.
  void close() { full_.signal(); }

  /// Values nobody took before the next one came.
  std::uint64_t superseded() const { return superseded_.load(std::memory_order_relaxed); }

 private:
  std::optional<T> empty_slot() {
    const std::unique_ptr<T> value(slot_.exchange(nullptr, std::memory_order_acq_rel));
    return value ? std::optional<T>(std::move(*value)) : std::nullopt;
  }

  std::atomic<T*> slot_ = nullptr;
  std::atomic<std::uint64_t> superseded_ = 0;
  /// One token while the slot is full, and one for the end.
  moodycamel::spsc_sema::LightweightSemaphore full_;
};

}  // namespace nadir::pipeline
