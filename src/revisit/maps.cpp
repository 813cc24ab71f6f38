// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "maps.hpp"

#include <algorithm>
#include <iterator>

namespace nadir::revisit {

bool joins_pairs(const Link& link, const std::vector<Node>& nodes) {
  return nodes[static_cast<std::size_t>(link.first)].metric &&
         nodes[static_cast<std::size_t>(link.second)].metric;
}

Similarity3 second_from_first(const Link& link, const std::vector<Node>& nodes) {
  Similarity3 step = link.second_from_first;
  if (joins_pairs(link, nodes)) {
    step.rigid.translation /= step.scale;
    step.scale = 1;
  }
  return step;
}

Similarity3 first_from_second(const Link& link, const std::vector<Node>& nodes) {
  const Node& a = nodes[static_cast<std::size_t>(link.first)];
  const Node& b = nodes[static_cast<std::size_t>(link.second)];
  return a.corrected_from_camera * second_from_first(link, nodes).inverse() *
         b.corrected_from_camera.inverse();
}

void Maps::add(const SettledKeyFrame& key_frame) {
  Node node(key_frame);
  map_of.try_emplace(node.submap, node.submap);
  double way = 0;
  if (!nodes.empty()) {
    way = swum.back();
    if (nodes.back().submap == node.submap) {
      node.corrected_from_camera = nodes.back().corrected_from_live() * Similarity3{1, node.live};
      way += (nodes.back().live.translation - node.live.translation).norm();
      if (!(node.depth > 0)) node.depth = nodes.back().depth;
    }
  }
  if (!(node.depth > 0)) node.depth = 1;
  nodes.push_back(std::move(node));
  swum.push_back(way);
}

std::vector<int> Maps::members(std::uint32_t map) const {
  std::vector<int> found;
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    if (map_at(i) == map) found.push_back(i);
  }
  return found;
}

bool Maps::is_metric(const std::vector<int>& members) const {
  return std::ranges::any_of(members, [&](int i) { return node(i).metric; });
}

std::vector<Link> Maps::links_of(std::uint32_t map) const {
  std::vector<Link> found;
  std::ranges::copy_if(links, std::back_inserter(found),
                       [&](const Link& link) { return map_at(link.first) == map; });
  return found;
}

}  // namespace nadir::revisit
