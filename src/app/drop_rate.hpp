// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What part of the images finds no room.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "nadir/core/stage_stats.hpp"

namespace nadir::app {

/// Images at the door of odometry since the start.
struct ImageFlow {
  std::uint64_t accepted = 0, dropped = 0;
};

class DropRate {
 public:
  /// Of the last ten calls' images, the part that odometry, or the stage of those behind it that
  /// keeps up the least, found no room for; 0 to 1.
  double observe(const ImageFlow& images, const std::vector<StageStats>& stages);

 private:
  struct Count {
    ImageFlow images;
    std::map<std::string, std::uint64_t> dropped;  ///< by stage
  };
  std::deque<Count> counts_;
};

}  // namespace nadir::app
