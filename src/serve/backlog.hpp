// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What one viewer has still to be sent: not a queue but a place in the retained records, so that a
// slow viewer costs no memory, skips what was superseded and ends complete.
#pragma once

#include <cstdint>
#include <vector>

#include "retained_records.hpp"

namespace nadir::serve {

/// What is still to be sent of a lane, newest first. The records outlive it.
class NewestFirst {
 public:
  NewestFirst(const RetainedRecords& records, Lane lane, std::uint64_t has)
      : records_(&records), lane_(lane), known_(has) {}

  /// Null when there is none.
  const Record* next();
  /// What next() returned was.
  void sent(const Record& record) { gaps_.back().last = record.sequence - 1; }

 private:
  /// Sequences among which records are still to be sent.
  struct Gap {
    std::uint64_t first, last;
  };
  void extend_to_newest();

  const RetainedRecords* records_;
  Lane lane_;
  std::uint64_t known_;
  std::vector<Gap> gaps_;  ///< ascending, disjoint
};

class Backlog {
 public:
  /// Of a viewer that has everything up to a sequence (0: nothing). The records outlive it.
  Backlog(const RetainedRecords& records, std::uint64_t has);

  /// The record to send next, taken as sent; null while there is none. State first; then the others
  /// in turn, live as thin_live over a thin link; CaughtUp when all that must be sent was.
  SharedBytes next(bool thin = false);
  /// What next() said last when all was sent.
  wire::Bytes caught_up() const;

 private:
  const RetainedRecords* records_;
  std::uint64_t state_sent_, live_sent_, told_;
  NewestFirst prompt_, data_;
  std::size_t turn_ = 0;
};

}  // namespace nadir::serve
