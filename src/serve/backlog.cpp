// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "backlog.hpp"

#include <array>

namespace nadir::serve {
namespace {

/// A viewer that falls behind again and again leaves a gap each time. Beyond this many the two
/// oldest become one, and what lay between them is sent twice: harmless, a record replaces itself.
constexpr std::size_t kMaxGaps = 64;

}  // namespace

const Record* NewestFirst::next() {
  extend_to_newest();
  while (!gaps_.empty()) {
    const Gap& gap = gaps_.back();
    if (const Record* record = records_->newest_within(lane_, gap.first, gap.last)) return record;
    gaps_.pop_back();
  }
  return nullptr;
}

void NewestFirst::extend_to_newest() {
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

Backlog::Backlog(const RetainedRecords& records, std::uint64_t has,
                 std::optional<std::uint8_t> only)
    : records_(&records),
      only_(only),
      state_sent_(has),
      live_sent_(has),
      told_(has),
      prompt_(records, Lane::prompt, has),
      data_(records, Lane::data, has) {}

const Record* Backlog::next_state() {
  while (const Record* state = records_->oldest_after(Lane::state, state_sent_)) {
    state_sent_ = state->sequence;
    if (!only_ || state->bytes->front() == *only_) return state;
  }
  return nullptr;
}

SharedBytes Backlog::next(bool thin) {
  if (const Record* state = next_state()) return state->bytes;
  if (only_) {
    told_ = records_->newest();
    return nullptr;
  }
  const Record* const prompt = prompt_.next();
  const Record* const data = data_.next();
  if (prompt == nullptr && data == nullptr && told_ < records_->newest()) {
    told_ = records_->newest();
    return std::make_shared<const wire::Bytes>(caught_up());
  }
  const Record* const live =
      records_->oldest_after(thin ? Lane::thin_live : Lane::live, live_sent_);
  const std::array waiting{prompt, live, data};  // as FairShares::kLanes
  std::optional<std::size_t> first;
  for (std::size_t lane = 0; lane < waiting.size(); ++lane) {
    if (waiting[lane] == nullptr) continue;
    if (!first || shares_.due(lane) < shares_.due(*first)) first = lane;
  }
  if (!first) return nullptr;
  const Record& record = *waiting[*first];
  shares_.took(*first, record.bytes->size());
  switch (FairShares::kLanes[*first]) {
    case Lane::prompt:
      prompt_.sent(record);
      break;
    case Lane::data:
      data_.sent(record);
      break;
    default:
      live_sent_ = record.sequence;
  }
  return record.bytes;
}

wire::Bytes Backlog::caught_up() const {
  return wire::encode(wire::CaughtUp{told_, records_->evicted()});
}

}  // namespace nadir::serve
