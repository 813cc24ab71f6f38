// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "drop_rate.hpp"

#include <algorithm>

namespace nadir::app {
namespace {

double part(std::uint64_t some, std::uint64_t all) {
  return all > 0 ? std::min(1.0, static_cast<double>(some) / static_cast<double>(all)) : 0;
}

// One item an image; to lose some of the others' (alerts, datagrams) costs no map.
bool works_on_images(const std::string& stage) {
  return stage == "plane" || stage == "mosaic2d" || stage == "projection3d";
}

}  // namespace

double DropRate::observe(const ImageFlow& images, const std::vector<StageStats>& stages) {
  constexpr std::size_t kCalls = 10;
  Count now{images, {}};
  for (const StageStats& stage : stages) {
    if (works_on_images(stage.stage)) now.dropped[stage.stage] = stage.dropped;
  }
  counts_.push_back(now);
  if (counts_.size() > kCalls + 1) counts_.pop_front();
  const Count& then = counts_.front();
  const std::uint64_t dropped = images.dropped - then.images.dropped;
  const std::uint64_t accepted = images.accepted - then.images.accepted;
  double worst = part(dropped, accepted + dropped);
  for (const auto& [stage, count] : now.dropped) {
    const auto before = then.dropped.find(stage);
    if (before != then.dropped.end())
      worst = std::max(worst, part(count - before->second, accepted));
  }
  return worst;
}

}  // namespace nadir::app
