// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The key frames that are settled, the maps they form, and the revisits that hold these together.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "link.hpp"
#include "node.hpp"

namespace nadir::revisit {

struct Maps {
  std::vector<Node> nodes;
  std::vector<double> swum;                       ///< by node, ground lengths along the way
  std::vector<Link> links;                        ///< within maps
  std::vector<Link> unproven;                     ///< between maps, waiting for a witness
  std::map<std::uint32_t, std::uint32_t> map_of;  ///< by sub-map: the first one it was joined to
  std::set<std::uint32_t> loose;                  ///< maps with links no adjustment knows yet
  std::set<std::uint32_t> dim;  ///< maps whose ground only blobs were found again on
  std::size_t next_abroad = 0;  ///< whose turn it is to be compared by blobs

  void add(const SettledKeyFrame& key_frame);

  Node& node(int i) { return nodes[static_cast<std::size_t>(i)]; }
  const Node& node(int i) const { return nodes[static_cast<std::size_t>(i)]; }
  std::uint32_t map_at(int i) const { return map_of.at(node(i).submap); }
  std::vector<int> members(std::uint32_t map) const;
  bool is_metric(const std::vector<int>& members) const;
  std::vector<Link> links_of(std::uint32_t map) const;
};

/// Both of its images belong to pairs of cameras.
bool joins_pairs(const Link& link, const std::vector<Node>& nodes);

/// Its measure, of which pairs of cameras know the scale better than guessed depths do.
Similarity3 second_from_first(const Link& link, const std::vector<Node>& nodes);

/// What a link says of the place of the second's map in the first's.
Similarity3 first_from_second(const Link& link, const std::vector<Node>& nodes);

}  // namespace nadir::revisit
