// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The dive's tie points in blocks of ids, so that what a window adds or moves replaces whole
// retained records.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "nadir/core/window.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::wire {

class TiePointBlocks {
 public:
  /// Takes the points in, new or known, and those given up out, and returns the whole of each block
  /// they touched, blocks ascending.
  std::vector<TiePoints> update(std::span<const TiePoint> points,
                                std::span<const std::uint64_t> given_up = {});
  /// Tie points known.
  std::size_t size() const;
  const std::map<std::uint64_t, TiePoints>& blocks() const { return blocks_; }

 private:
  std::map<std::uint64_t, TiePoints> blocks_;
};

}  // namespace nadir::wire
