// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/wire/tie_point_blocks.hpp"

#include <algorithm>
#include <numeric>
#include <set>

namespace nadir::wire {
namespace {

auto place_of(std::uint64_t id, TiePoints& block) {
  return std::lower_bound(
      block.points.begin(), block.points.end(), id % kTiePointBlock,
      [](const TiePoints::Point& one, std::uint64_t other) { return one.index < other; });
}

void place(const TiePoint& point, TiePoints& block) {
  const auto index = static_cast<std::uint16_t>(point.id % kTiePointBlock);
  auto at = place_of(point.id, block);
  if (at == block.points.end() || at->index != index) {
    at = block.points.insert(at, {.index = index});
  }
  const Eigen::Vector3f offset = (point.x_in_survey - block.origin).cast<float>();
  at->offset = {offset.x(), offset.y(), offset.z()};
  at->rgb = point.rgb;
}

}  // namespace

std::vector<TiePoints> TiePointBlocks::update(std::span<const TiePoint> points,
                                              std::span<const std::uint64_t> given_up) {
  std::set<std::uint64_t> touched;
  for (const TiePoint& point : points) {
    const std::uint64_t number = point.id / kTiePointBlock;
    auto [block, is_new] = blocks_.try_emplace(number);
    if (is_new) {
      block->second.block = number;
      block->second.origin = point.x_in_survey;
    }
    place(point, block->second);
    touched.insert(number);
  }
  for (const std::uint64_t id : given_up) {
    const auto block = blocks_.find(id / kTiePointBlock);
    if (block == blocks_.end()) continue;
    const auto at = place_of(id, block->second);
    if (at == block->second.points.end() || at->index != id % kTiePointBlock) continue;
    block->second.points.erase(at);
    touched.insert(block->first);
  }
  std::vector<TiePoints> changed;
  changed.reserve(touched.size());
  for (const std::uint64_t number : touched) {
    changed.push_back(blocks_.at(number));
  }
  return changed;
}

std::size_t TiePointBlocks::size() const {
  return std::accumulate(
      blocks_.begin(), blocks_.end(), std::size_t{0},
      [](std::size_t sum, const auto& block) { return sum + block.second.points.size(); });
}

}  // namespace nadir::wire
