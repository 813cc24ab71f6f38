// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Recorded dives for pages: each is read again into a feed of its own for as long as somebody
// watches it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "nadir/serve/feed.hpp"

namespace nadir::app {

class RecordedFeeds {
 public:
  using Clock = std::chrono::steady_clock;
  using MakeFeed = std::function<std::shared_ptr<serve::Feed>()>;

  static constexpr std::size_t kMost = 2;  ///< open at a time: each is tens of MB

  /// unwatched: how long a feed is kept that nobody watches.
  explicit RecordedFeeds(Clock::duration unwatched = std::chrono::minutes(1));
  /// Ends what is being read, within a record or a row of tiles.
  ~RecordedFeeds();
  RecordedFeeds(const RecordedFeeds&) = delete;
  RecordedFeeds& operator=(const RecordedFeeds&) = delete;

  /// Until then there are no feeds. Any thread.
  void make_by(MakeFeed make);

  /// That of the dive in this folder, which a thread fills meanwhile. One more than kMost takes the
  /// place of the one asked for the longest ago among those nobody watches. Null when all are
  /// watched, or those before are not ended yet.
  std::shared_ptr<serve::Feed> find(const std::filesystem::path& dive);
  /// Its viewers are sent away. By the thread that finds.
  void close(const std::filesystem::path& dive);

 private:
  class Reading;
  bool make_room();

  const Clock::duration unwatched_;
  std::mutex mutex_;  ///< of the next
  MakeFeed make_;
  std::vector<std::unique_ptr<Reading>> readings_;  ///< the one asked for the longest ago first
};

}  // namespace nadir::app
