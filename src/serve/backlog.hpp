// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What one viewer has still to be sent: not a queue but a place in the retained records, so that a
// slow viewer costs no memory, skips what was superseded and ends complete.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Shares a link among lanes by the bytes they send (start-time fair queueing, Goyal, Vin and Cheng
/// 1996): however large the records of one, another with something to send has its part.
class FairShares {
 public:
  /// Twice as much of a link for what is prompt.
  static constexpr std::array kLanes{Lane::prompt, Lane::live, Lane::data};
  static constexpr std::array kWeights{2.0, 1.0, 1.0};

  /// When a lane of kLanes is due; the least is the next.
  double due(std::size_t lane) const { return std::max(now_, free_[lane]); }
  void took(std::size_t lane, std::size_t bytes) {
    now_ = due(lane);
    free_[lane] = now_ + static_cast<double>(bytes) / kWeights[lane];
  }

 private:
  double now_ = 0;
  std::array<double, kLanes.size()> free_{};
};

class Backlog {
 public:
  /// Of a viewer that has everything up to a sequence (0: nothing). The records outlive it.
  /// only: of the state lane, those of this type, and nothing else.
  Backlog(const RetainedRecords& records, std::uint64_t has, std::optional<std::uint8_t> only = {});

  /// The record to send next, taken as sent; null while there is none. State first; then the others
  /// by their shares, live as thin_live over a thin link; CaughtUp when all that must be sent was.
  SharedBytes next(bool thin = false);
  /// What next() said last when all was sent.
  wire::Bytes caught_up() const;

 private:
  const Record* next_state();

  const RetainedRecords* records_;
  std::optional<std::uint8_t> only_;
  std::uint64_t state_sent_, live_sent_, told_;
  NewestFirst prompt_, data_;
  FairShares shares_;
};

}  // namespace nadir::serve
