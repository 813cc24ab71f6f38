// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "recognition.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>

#include "nadir/odometry/correspondence.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;

constexpr int kSureJoin = 80;    // corners that need no second pair of images as witness
constexpr double kReach = 0.6;   // of the footprint, between the centres of overlapping images
constexpr double kDrift = 0.02;  // of the distance swum, errors of the poses that are feared
constexpr std::size_t kMostAlike = 40;  // key frames of other sub-maps compared with each new one
constexpr int kMinLikeness = 8;         // of images of other sub-maps, to be tried
constexpr int kMinLikenessAtHome = 4;   // where the map says that they overlap
constexpr std::size_t kAbroad = 2;      // of those, tried

bool agree(const Link& link, const Link& witness, const std::vector<Node>& nodes) {
  constexpr double kTurn = 0.06, kShift = 0.25, kScale = 0.1;  // radians, depths, relative
  const Similarity3 one = first_from_second(link, nodes), other = first_from_second(witness, nodes);
  const Node& b = nodes[static_cast<std::size_t>(link.second)];
  const Vector3d centre = b.ground_centre();
  return one.rigid.rotation.angularDistance(other.rigid.rotation) < kTurn &&
         std::abs(std::log(one.scale / other.scale)) < kScale &&
         (one * centre - other * centre).norm() <
             kShift * one.scale * b.corrected_from_camera.scale * b.depth;
}

// Key frames of the newest one's map, or of all others, by the distance of their ground.
std::vector<int> others(const Maps& maps, int newest, bool same_map) {
  std::vector<std::pair<double, int>> found;
  const Vector3d centre = maps.node(newest).ground_centre();
  for (int i = 0; i < newest; ++i) {
    if ((maps.map_at(i) == maps.map_at(newest)) != same_map) continue;
    const Node& other = maps.node(i);
    if (!other.prior.known()) continue;
    found.emplace_back((other.ground_centre() - centre).norm(), i);
  }
  std::ranges::sort(found);
  std::vector<int> order;
  order.reserve(found.size());
  for (const auto& [distance, i] : found) order.push_back(i);
  return order;
}

// The ground does not tilt between two visits. But where a vertical was guessed from the plane of
// the first ground, a wreck's side say, maps may lie against each other in any way.
bool is_upright(const Link& link, const Maps& maps, const Config& config) {
  const bool measured = maps.node(link.first).upright && maps.node(link.second).upright;
  if (!measured && maps.map_at(link.first) != maps.map_at(link.second)) return true;
  const Similarity3 placed = first_from_second(link, maps.nodes);
  const double tilt = std::acos(
      std::clamp((placed.rigid.rotation * Vector3d::UnitZ()).dot(Vector3d::UnitZ()), -1.0, 1.0));
  return tilt < config.max_tilt_deg * std::numbers::pi / 180;
}

// The later map is moved onto the earlier.
void join(Maps& maps, const Link& link, const Config& config, Time time, Revision& out) {
  const std::uint32_t first = maps.map_at(link.first), second = maps.map_at(link.second);
  Similarity3 moved = first_from_second(link, maps.nodes);
  const bool forward = first < second;
  if (!forward) moved = moved.inverse();
  const std::uint32_t kept = std::min(first, second), gone = std::max(first, second);
  const std::vector<int> earlier = maps.members(kept), later = maps.members(gone);
  if (maps.is_metric(later) &&
      !maps.is_metric(earlier)) {  // only now the earlier one can be in metres
    const Similarity3 grown{1 / moved.scale, {}};
    for (const int i : earlier)
      maps.node(i).corrected_from_camera = grown * maps.node(i).corrected_from_camera;
    moved = grown * moved;
  }
  for (Node& n : maps.nodes) {
    if (maps.map_of.at(n.submap) == gone) n.corrected_from_camera = moved * n.corrected_from_camera;
  }
  for (auto& [submap, map] : maps.map_of) {
    if (map == gone) map = kept;
  }
  if (maps.dim.erase(gone) > 0) maps.dim.insert(kept);
  maps.links.push_back(link);
  const auto proven = [&](const Link& other) {
    return maps.map_at(other.first) == maps.map_at(other.second);
  };
  std::ranges::copy_if(maps.unproven, std::back_inserter(maps.links), [&](const Link& other) {
    return proven(other) && agree(link, other, maps.nodes);
  });
  std::erase_if(maps.unproven, proven);
  // Their common ground is known now: more pairs of images show it.
  constexpr std::size_t kMost = 20;
  for (std::size_t i = 0; i < std::min(kMost, later.size()); ++i)
    look_at_home(maps, later[i], config);
  maps.loose.erase(gone);
  maps.loose.insert(kept);
  const int proof = forward ? link.second : link.first,
            witness = forward ? link.first : link.second;
  out.joins.push_back({gone, kept, maps.node(proof).image, maps.node(witness).image});
  out.alerts.push_back({time, maps.node(proof).image, AlertKind::submap_joined,
                        "sub-map " + std::to_string(gone) + " was joined to sub-map " +
                            std::to_string(kept) + ": image " +
                            std::to_string(maps.node(proof).image) + " shows the ground of image " +
                            std::to_string(maps.node(witness).image),
                        "none needed"});
}

bool try_join(Maps& maps, const Link& link, const Config& config, Time time, Revision& out) {
  const auto is_witness = [&](const Link& other) {
    return maps.map_at(other.first) == maps.map_at(link.first) &&
           maps.map_at(other.second) == maps.map_at(link.second) && other.second != link.second &&
           agree(link, other, maps.nodes);
  };
  if (link.inliers < kSureJoin && std::ranges::none_of(maps.unproven, is_witness)) {
    maps.unproven.push_back(link);
    return false;
  }
  join(maps, link, config, time, out);
  return true;
}

constexpr int kMinCommon = 12;  // of the strongest blobs, to be tried

int common_blobs(Maps& maps, int first, int second) {
  return odometry::likeness(maps.node(second).find_blobs(), maps.node(first).find_blobs());
}

bool join_by_blobs(Maps& maps, int first, int second, const Config& config, Time time,
                   Revision& out) {
  const auto found = link_by_blobs(maps.nodes, first, second);
  if (!found || !is_upright(*found, maps, config)) return false;
  const std::uint32_t kept = std::min(maps.map_at(first), maps.map_at(second));
  if (!try_join(maps, *found, config, time, out)) return false;
  maps.dim.insert(kept);
  return true;
}

// Slow, so that the key frames of other maps take turns.
void look_abroad_by_blobs(Maps& maps, int newest, const Config& config, Time time, Revision& out) {
  constexpr std::size_t kAtOnce = 4;
  if (newest % 2 != 0) return;  // its neighbours see nearly the same
  const std::vector<int> order = others(maps, newest, false);
  for (std::size_t turn = 0; turn < std::min(kAtOnce, order.size()); ++turn) {
    const int i = order[maps.next_abroad++ % order.size()];
    if (common_blobs(maps, i, newest) < kMinCommon) continue;
    if (join_by_blobs(maps, i, newest, config, time, out)) return;
  }
}

// Pairs of key frames of different maps, of at most so many: every n-th key frame, as neighbours
// see nearly the same.
std::vector<std::pair<int, int>> pairs_abroad(const Maps& maps, std::size_t most) {
  std::vector<std::pair<int, int>> pairs;
  const int count = static_cast<int>(maps.nodes.size());
  for (int stride = 1;; ++stride) {
    pairs.clear();
    for (int second = 0; second < count && pairs.size() <= most; second += stride) {
      for (int first = 0; first < second && pairs.size() <= most; first += stride) {
        if (maps.map_at(first) != maps.map_at(second)) pairs.emplace_back(first, second);
      }
    }
    if (pairs.size() <= most) return pairs;
  }
}

}  // namespace

// Earlier images that should overlap, by the map's own geometry and its uncertainty.
void look_at_home(Maps& maps, int newest, const Config& config) {
  const Node& own = maps.node(newest);
  int tried = 0;
  for (const int i : others(maps, newest, true)) {
    if (tried == config.candidates) break;
    if (maps.node(i).submap == own.submap && newest - i < config.gap) continue;
    const double distance = (maps.node(i).ground_centre() - own.ground_centre()).norm();
    const double way =
        maps.swum[static_cast<std::size_t>(newest)] - maps.swum[static_cast<std::size_t>(i)];
    const double footprint = own.footprint();
    if (distance > (kReach + 1) * footprint) break;
    if (distance > kReach * footprint + std::min(kDrift * way, footprint)) continue;
    ++tried;
    const auto is_this = [&](const Link& l) { return l.first == i && l.second == newest; };
    if (std::ranges::any_of(maps.links, is_this)) continue;
    auto found = odometry::likeness(own.features, maps.node(i).features) < kMinLikenessAtHome
                     ? std::nullopt
                     : link(maps.nodes, i, newest);
    if (!found && maps.dim.contains(maps.map_at(newest))) {
      found = link_by_blobs(maps.nodes, i, newest);
    }
    if (!found || !is_upright(*found, maps, config)) continue;
    maps.links.push_back(*found);
    maps.loose.insert(maps.map_at(newest));
  }
}

// Images of other maps that look alike.
void look_abroad(Maps& maps, int newest, const Config& config, Time time, Revision& out) {
  std::vector<int> order = others(maps, newest, false);
  if (order.size() > kMostAlike) order.resize(kMostAlike);
  std::vector<std::pair<int, int>> alike;  // likeness, node
  for (const int i : order) {
    const int likeness = odometry::likeness(maps.node(newest).features, maps.node(i).features);
    if (likeness >= kMinLikeness) alike.emplace_back(-likeness, i);
  }
  std::ranges::sort(alike);
  if (alike.size() > kAbroad) alike.resize(kAbroad);
  for (const auto& [likeness, i] : alike) {
    const auto found = link(maps.nodes, i, newest);
    if (found && is_upright(*found, maps, config) && try_join(maps, *found, config, time, out))
      return;
  }
  look_abroad_by_blobs(maps, newest, config, time, out);
}

// The live search took turns; now there is time for all over.
void look_all_over(Maps& maps, const Config& config, Time time, Revision& out) {
  constexpr std::size_t kMostCompared = 300, kMostTried = 30;
  constexpr int kAround = 2;  // key frames before and after, for a witness
  std::vector<std::pair<int, std::pair<int, int>>> alike;
  for (const auto& [first, second] : pairs_abroad(maps, kMostCompared)) {
    const int common = common_blobs(maps, first, second);
    if (common >= kMinCommon) alike.push_back({-common, {first, second}});
  }
  std::ranges::sort(alike);
  if (alike.size() > kMostTried) alike.resize(kMostTried);
  const int count = static_cast<int>(maps.nodes.size());
  for (const auto& [less, pair] : alike) {
    const int first = pair.first, found_in = pair.second;
    const std::size_t unproven = maps.unproven.size();
    const auto tried = [&](int second) {
      return maps.map_at(first) == maps.map_at(second) ||
             join_by_blobs(maps, first, second, config, time, out);
    };
    if (tried(found_in) || maps.unproven.size() == unproven) continue;
    for (int second = std::max(first + 1, found_in - kAround);
         second <= std::min(count - 1, found_in + kAround); ++second) {
      if (second != found_in && tried(second)) break;
    }
  }
}

}  // namespace nadir::revisit
