// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/wire/tie_point_blocks.hpp"

#include <algorithm>
#include <numeric>
#include <set>

namespace nadir::wire {
namespace {

void place(const TiePoint& point, TiePoints& block) {
  const auto index = static_cast<std::uint16_t>(point.id % kTiePointBlock);
  auto at = std::lower_bound(
      block.points.begin(), block.points.end(), index,
      [](const TiePoints::Point& one, std::uint16_t other) { return one.index < other; });
  if (at == block.points.end() || at->index != index) {
    at = block.points.insert(at, {.index = index});
  }
  const Eigen::Vector3f offset = (point.x_in_survey - block.origin).cast<float>();
  at->offset = {offset.x(), offset.y(), offset.z()};
  at->rgb = point.rgb;
}

}  // namespace

std::vector<TiePoints> TiePointBlocks::update(std::span<const TiePoint> points) {
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
  std::vector<TiePoints> changed;
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
