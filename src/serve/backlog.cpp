// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "backlog.hpp"

namespace nadir::serve {
namespace {

/// A viewer that falls behind again and again leaves a gap each time. Beyond this many the two
/// oldest become one, and what lay between them is sent twice: harmless, a record replaces itself.
constexpr std::size_t kMaxGaps = 64;

}  // namespace

Backlog::Backlog(const RetainedRecords& records, std::uint64_t has)
    : records_(&records), state_sent_(has), live_sent_(has), known_(has), told_(has) {}

SharedBytes Backlog::next(bool thin) {
  if (const Record* state = records_->oldest_after(Lane::state, state_sent_)) {
    state_sent_ = state->sequence;
    return state->bytes;
  }
  const Record* data = newest_data();
  if (data == nullptr && told_ < records_->newest()) {
    told_ = records_->newest();
    return std::make_shared<const wire::Bytes>(caught_up());
  }
  const Record* live = records_->oldest_after(thin ? Lane::thin_live : Lane::live, live_sent_);
  if (live != nullptr && (data == nullptr || live_turn_)) {
    live_turn_ = false;
    live_sent_ = live->sequence;
    return live->bytes;
  }
  if (data == nullptr) return nullptr;
  live_turn_ = true;
  gaps_.back().last = data->sequence - 1;
  return data->bytes;
}

wire::Bytes Backlog::caught_up() const {
  return wire::encode(wire::CaughtUp{told_, records_->evicted()});
}

const Record* Backlog::newest_data() {
  extend_to_newest();
  while (!gaps_.empty()) {
    const Gap& gap = gaps_.back();
    if (const Record* data = records_->newest_within(Lane::data, gap.first, gap.last)) return data;
    gaps_.pop_back();
  }
  return nullptr;
}

void Backlog::extend_to_newest() {
  if (known_ >= records_->newest()) return;
  if (!gaps_.empty() && gaps_.back().last == known_) {
    gaps_.back().last = records_->newest();
  } else {
    gaps_.push_back({known_ + 1, records_->newest()});
  }
  known_ = records_->newest();
  if (gaps_.size() > kMaxGaps) {
    gaps_[1].first = gaps_[0].first;
    gaps_.erase(gaps_.begin());
  }
}

}  // namespace nadir::serve
