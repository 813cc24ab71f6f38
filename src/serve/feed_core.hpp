// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A feed as the server's thread knows it.
#pragma once

#include <functional>
#include <memory>
#include <set>

#include "nadir/serve/feed.hpp"
#include "retained_records.hpp"
#include "shared.hpp"

namespace nadir::serve {

class Viewer;

/// Changed and read by the server's thread, but for what says otherwise.
class Feed::Core {
 public:
  /// Has the server's thread do something, or drops it when there is none any more. Any thread.
  using Post = std::function<void(std::function<void()>)>;

  /// shared: outlives what is posted.
  Core(std::uint64_t id, std::size_t retained_bytes, Shared& shared, Post post);

  const std::uint64_t id;  ///< names it to viewers who come back
  RetainedRecords records;
  Shared& shared;
  std::set<std::shared_ptr<Viewer>> viewers;
  Count viewer_count = 0;  ///< any thread
  bool has_ended = false;  ///< nobody may join

  void put(Lane lane, std::uint64_t key, wire::Bytes record);
  void end();
  const Post post;  ///< any thread
};

}  // namespace nadir::serve
