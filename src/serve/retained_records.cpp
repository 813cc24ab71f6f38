// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "retained_records.hpp"

#include <iterator>
#include <utility>

namespace nadir::serve {

void RetainedRecords::put(Lane lane, std::uint64_t key, wire::Bytes record) {
  const std::uint64_t sequence = ++last_sequence_;
  wire::set_sequence(record, sequence);
  if (lane != Lane::live && lane != Lane::thin_live) newest_ = sequence;

  Shelf& own = shelf(lane);
  const auto old = own.sequence_of_key.find(key);
  if (old != own.sequence_of_key.end()) remove(own, old->second);
  bytes_ += record.size();
  own.by_sequence[sequence] = {sequence, key,
                               std::make_shared<const wire::Bytes>(std::move(record))};
  own.sequence_of_key[key] = sequence;
  while (bytes_ > budget_ &&
         (evict_oldest(shelf(Lane::data)) || evict_oldest(shelf(Lane::prompt)) ||
          evict_oldest(shelf(Lane::state)))) {
  }
}

const Record* RetainedRecords::oldest_after(Lane lane, std::uint64_t sequence) const {
  const auto& records = shelf(lane).by_sequence;
  const auto found = records.upper_bound(sequence);
  return found == records.end() ? nullptr : &found->second;
}

const Record* RetainedRecords::newest_within(Lane lane, std::uint64_t first,
                                             std::uint64_t last) const {
  const auto& records = shelf(lane).by_sequence;
  const auto beyond = records.upper_bound(last);
  if (beyond == records.begin()) return nullptr;
  const Record& found = std::prev(beyond)->second;
  return found.sequence < first ? nullptr : &found;
}

void RetainedRecords::remove(Shelf& shelf, std::uint64_t sequence) {
  const auto found = shelf.by_sequence.find(sequence);
  bytes_ -= found->second.bytes->size();
  shelf.sequence_of_key.erase(found->second.key);
  shelf.by_sequence.erase(found);
}

bool RetainedRecords::evict_oldest(Shelf& shelf) {
  if (shelf.by_sequence.empty()) return false;
  remove(shelf, shelf.by_sequence.begin()->first);
  ++evicted_;
  return true;
}

}  // namespace nadir::serve
