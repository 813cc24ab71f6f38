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

Backlog::Backlog(const RetainedRecords& records, std::uint64_t has)
    : records_(&records),
      state_sent_(has),
      live_sent_(has),
      told_(has),
      prompt_(records, Lane::prompt, has),
      data_(records, Lane::data, has) {}

SharedBytes Backlog::next(bool thin) {
  if (const Record* state = records_->oldest_after(Lane::state, state_sent_)) {
    state_sent_ = state->sequence;
    return state->bytes;
  }
  const Record* const prompt = prompt_.next();
  const Record* const data = data_.next();
  if (prompt == nullptr && data == nullptr && told_ < records_->newest()) {
    told_ = records_->newest();
    return std::make_shared<const wire::Bytes>(caught_up());
  }
  const Record* const live =
      records_->oldest_after(thin ? Lane::thin_live : Lane::live, live_sent_);
  constexpr std::array kTurns{Lane::prompt, Lane::live, Lane::prompt, Lane::data};
  for (std::size_t tried = 0; tried < kTurns.size(); ++tried) {
    const Lane lane = kTurns[turn_++ % kTurns.size()];
    if (lane == Lane::prompt && prompt != nullptr) {
      prompt_.sent(*prompt);
      return prompt->bytes;
    }
    if (lane == Lane::live && live != nullptr) {
      live_sent_ = live->sequence;
      return live->bytes;
    }
    if (lane == Lane::data && data != nullptr) {
      data_.sent(*data);
      return data->bytes;
    }
  }
  return nullptr;
}

wire::Bytes Backlog::caught_up() const {
  return wire::encode(wire::CaughtUp{told_, records_->evicted()});
}

}  // namespace nadir::serve
