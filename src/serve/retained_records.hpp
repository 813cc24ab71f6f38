// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The newest record of each key: what a viewer must be sent to see the scene as it stands.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <unordered_map>

#include "nadir/serve/feed.hpp"
#include "nadir/wire/envelope.hpp"

namespace nadir::serve {

using SharedBytes = std::shared_ptr<const wire::Bytes>;

struct Record {
  std::uint64_t sequence = 0;
  std::uint64_t key = 0;
  SharedBytes bytes;
};

class RetainedRecords {
 public:
  explicit RetainedRecords(std::size_t budget_bytes) : budget_(budget_bytes) {}

  /// Numbers the record, replaces the one of its lane and key, and keeps within the budget by
  /// letting go of the oldest data, then of what is prompt, then of state.
  void put(Lane lane, std::uint64_t key, wire::Bytes record);

  /// Null when there is none.
  const Record* oldest_after(Lane lane, std::uint64_t sequence) const;
  const Record* newest_within(Lane lane, std::uint64_t first, std::uint64_t last) const;

  std::uint64_t newest() const { return newest_; }  ///< sequence of the last record but live ones
  std::uint64_t evicted() const { return evicted_; }
  std::size_t bytes() const { return bytes_; }

 private:
  struct Shelf {
    std::map<std::uint64_t, Record> by_sequence;
    std::unordered_map<std::uint64_t, std::uint64_t> sequence_of_key;
  };
  Shelf& shelf(Lane lane) { return shelves_[static_cast<std::size_t>(lane)]; }
  const Shelf& shelf(Lane lane) const { return shelves_[static_cast<std::size_t>(lane)]; }
  void remove(Shelf& shelf, std::uint64_t sequence);
  bool evict_oldest(Shelf& shelf);

  const std::size_t budget_;
  std::array<Shelf, 5> shelves_;
  std::uint64_t last_sequence_ = 0, newest_ = 0, evicted_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace nadir::serve
