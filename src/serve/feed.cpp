// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/serve/feed.hpp"

#include <utility>

#include "feed_core.hpp"
#include "nadir/core/check.hpp"
#include "viewer.hpp"

namespace nadir::serve {

Feed::Core::Core(std::uint64_t number, std::size_t retained_bytes, Shared& all, Post to_server)
    : id(number), records(retained_bytes), shared(all), post(std::move(to_server)) {}

void Feed::Core::put(Lane lane, std::uint64_t key, wire::Bytes record) {
  if (has_ended) return;
  const std::uint64_t bytes = records.bytes(), evicted = records.evicted();
  records.put(lane, key, std::move(record));
  shared.tally.retained_bytes += records.bytes() - bytes;
  shared.tally.evicted += records.evicted() - evicted;
  for (const auto& viewer : viewers) viewer->wake();
}

void Feed::Core::end() {
  if (std::exchange(has_ended, true)) return;
  shared.tally.retained_bytes -= records.bytes();
  for (const auto& viewer : viewers) viewer->send_away();
}

Feed::Feed(std::shared_ptr<Core> core) : core_(std::move(core)) {}

Feed::~Feed() {
  core_->post([core = core_] { core->end(); });
}

void Feed::publish(Lane lane, std::uint64_t key, wire::Bytes record) {
  NADIR_CHECK(record.size() >= wire::kHeaderSize, record.size());
  const auto moved = std::make_shared<wire::Bytes>(std::move(record));
  core_->post([core = core_, lane, key, moved] { core->put(lane, key, std::move(*moved)); });
}

std::uint64_t Feed::viewers() const { return core_->viewer_count; }

}  // namespace nadir::serve
