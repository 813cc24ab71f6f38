// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The edge between two stages: a bounded ring for one producer and one consumer, without locks.
#pragma once

#include <readerwriterqueue/atomicops.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace nadir::pipeline {

/// What the producer does at a full channel. Newest wins is LatestValue.
enum class WhenFull { wait, drop };

/// Sleeps in the kernel only when there is nothing to take; one waiter, any number of signallers.
using Bell = moodycamel::spsc_sema::LightweightSemaphore;

/// What a channel is apart from its items. The bell holds one token for each item waiting and one
/// for each end, so a consumer of several channels waits on the one bell they share.
class Edge {
 public:
  Edge(std::size_t capacity, WhenFull, std::shared_ptr<Bell>);
  Edge(const Edge&) = delete;
  Edge& operator=(const Edge&) = delete;

  /// By the producer, after its last push: the consumer still gets what waits, then the end.
  void close();
  /// By anyone: "stop now". Neither end ever blocks again, what waits is never delivered.
  void abandon();

  /// Nothing more will come: closed and empty, or abandoned.
  bool ended() const;
  std::size_t depth() const;       ///< items waiting
  std::uint64_t dropped() const;   ///< items refused because the channel was full
  std::uint64_t accepted() const;  ///< items pushed since the start
  const std::shared_ptr<Bell>& bell() const { return bell_; }

 protected:
  ~Edge() = default;
  /// Room for one item: waits or counts a drop when there is none. False when the item is not
  /// wanted.
  bool reserve();

  static constexpr std::size_t kCacheLine = 64;
  alignas(kCacheLine) std::atomic<std::uint64_t> pushed_ = 0;
  alignas(kCacheLine) std::atomic<std::uint64_t> popped_ = 0;
  Bell room_;
  std::shared_ptr<Bell> bell_;

 private:
  const WhenFull when_full_;
  std::atomic<std::uint64_t> dropped_ = 0;
  std::atomic<bool> closed_ = false, abandoned_ = false;
};

/// T is movable. Both threads must have ended before the channel is destroyed.
template <class T>
class Channel : public Edge {
 public:
  /// capacity: at least 1. bell: shared by the channels of one consumer.
  Channel(std::size_t capacity, WhenFull when_full,
          std::shared_ptr<Bell> bell = std::make_shared<Bell>())
      : Edge(capacity, when_full, std::move(bell)), ring_(capacity) {}

  /// Waits or drops when full, as the channel was made. False when the item was not taken: dropped
  /// (and counted), or the channel was abandoned.
  bool push(T item) {
    if (!reserve()) return false;
    const std::uint64_t n = pushed_.load(std::memory_order_relaxed);
    ring_[n % ring_.size()] = std::move(item);
    pushed_.store(n + 1, std::memory_order_release);
    bell_->signal();
    return true;
  }

  /// Waits for the next item; none at the end, and ever after. Only for a bell of its own.
  std::optional<T> pop() {
    bell_->wait();
    std::optional<T> item = take();
    if (!item) bell_->signal();
    return item;
  }

  /// The next item if one is there. The caller has waited for the bell.
  std::optional<T> take() {
    const std::uint64_t n = popped_.load(std::memory_order_relaxed);
    if (n == pushed_.load(std::memory_order_acquire) || ended()) return std::nullopt;
    std::optional<T> item = std::exchange(ring_[n % ring_.size()], std::nullopt);
    popped_.store(n + 1, std::memory_order_release);
    room_.signal();
    return item;
  }

 private:
  std::vector<std::optional<T>> ring_;
};

}  // namespace nadir::pipeline
