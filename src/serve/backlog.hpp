// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What one viewer has still to be sent: not a queue but a place in the retained records, so that a
// slow viewer costs no memory, skips what was superseded and ends complete.
#pragma once

#include <cstdint>
#include <vector>

#include "retained_records.hpp"

namespace nadir::serve {

class Backlog {
 public:
  /// Of a viewer that has everything up to a sequence (0: nothing). The records outlive it.
  Backlog(const RetainedRecords& records, std::uint64_t has);

  /// The record to send next, taken as sent; null while there is none. State first; then data,
  /// newest first, in turn with live, which is thin_live over a thin link; CaughtUp when all that
  /// must be sent was.
  SharedBytes next(bool thin = false);
  /// What next() said last when all was sent.
  wire::Bytes caught_up() const;

 private:
  /// Sequences among which data records are still to be sent.
  struct Gap {
    std::uint64_t first, last;
  };
  const Record* newest_data();
  void extend_to_newest();

  const RetainedRecords* records_;
  std::uint64_t state_sent_, live_sent_, known_, told_;
  std::vector<Gap> gaps_;  ///< ascending, disjoint
  bool live_turn_ = true;
};

}  // namespace nadir::serve
