// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/revisit/revisit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "link.hpp"
#include "map_adjustment.hpp"
#include "nadir/odometry/correspondence.hpp"
#include "pose_graph.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;

constexpr int kPeriod = 10;      // key frames between adjustments of the pose graph
constexpr int kSureJoin = 80;    // corners that need no second pair of images as witness
constexpr double kReach = 0.6;   // of the footprint, between the centres of overlapping images
constexpr double kDrift = 0.02;  // of the distance swum, errors of the poses that are feared
constexpr std::size_t kMostAlike = 40;  // key frames of other sub-maps compared with each new one
constexpr int kMinLikeness = 8;         // of images of other sub-maps, to be tried
constexpr int kMinLikenessAtHome = 4;   // where the map says that they overlap
constexpr std::size_t kAbroad = 2;      // of those, tried

// Errors of odometry from one key frame to the next, and of a revisit: what they weigh against each
// other. Of corners in half a pixel, and of depths guessed from the neighbourhood.
constexpr double kStepRotation = 5e-4, kStepTranslation = 1e-3, kStepScale = 1e-3;
constexpr double kLinkRotation = 2e-3, kLinkTranslation = 4e-3, kLinkScale = 1e-2;
constexpr double kKnownScale = 1e-6;

bool joins_pairs(const Link& link, const std::vector<Node>& nodes) {
  return nodes[static_cast<std::size_t>(link.first)].metric &&
         nodes[static_cast<std::size_t>(link.second)].metric;
}

// Pairs of cameras know their lengths better than guessed depths do.
Similarity3 second_from_first(const Link& link, const std::vector<Node>& nodes) {
  Similarity3 step = link.second_from_first;
  if (joins_pairs(link, nodes)) {
    step.rigid.translation /= step.scale;
    step.scale = 1;
  }
  return step;
}

Edge edge_of(const Link& link, const std::vector<Node>& nodes) {
  const Node& second = nodes[static_cast<std::size_t>(link.second)];
  Edge edge{link.first,
            link.second,
            second_from_first(link, nodes),
            kLinkRotation,
            kLinkTranslation * second.depth,
            kLinkScale,
            true};
  if (joins_pairs(link, nodes)) edge.sigma_scale = kKnownScale;
  return edge;
}

Edge step(int first, int second, const std::vector<Node>& nodes) {
  const Node& a = nodes[static_cast<std::size_t>(first)];
  const Node& b = nodes[static_cast<std::size_t>(second)];
  return {first,
          second,
          {1, b.live.inverse() * a.live},
          kStepRotation,
          kStepTranslation * b.depth,
          a.metric && b.metric ? kKnownScale : kStepScale,
          false};
}

/// What a link says of the place of the second's map in the first's.
Similarity3 first_from_second(const Link& link, const std::vector<Node>& nodes) {
  const Node& a = nodes[static_cast<std::size_t>(link.first)];
  const Node& b = nodes[static_cast<std::size_t>(link.second)];
  return a.corrected_from_camera * second_from_first(link, nodes).inverse() *
         b.corrected_from_camera.inverse();
}

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

}  // namespace

struct Revisit::State {
  Config config;
  std::vector<Node> nodes;
  std::vector<double> swum;                       ///< by node, ground lengths along the way
  std::vector<Link> links;                        ///< within maps
  std::vector<Link> unproven;                     ///< between maps, waiting for a witness
  std::map<std::uint32_t, std::uint32_t> map_of;  ///< by sub-map: the first one it was joined to
  std::map<std::uint32_t, ScaleEstimate> scales;  ///< measured, by sub-map
  std::map<std::uint64_t, Similarity3> told;      ///< by image
  std::set<std::uint32_t> loose;                  ///< maps with links the graph does not hold yet
  int since_adjusted = 0;
  Time time = 0;  ///< of the newest shot

  Node& node(int i) { return nodes[static_cast<std::size_t>(i)]; }
  std::uint32_t map_at(int i) const { return map_of.at(nodes[static_cast<std::size_t>(i)].submap); }
  void add(const SettledKeyFrame& key_frame);
  bool is_first_of_measured(const SettledKeyFrame& key_frame) const;
  void look_at_home(int newest);
  void look_abroad(int newest, Revision& out);
  std::vector<int> others(int newest, bool same_map) const;
  bool is_upright(const Link& link) const;
  bool try_join(const Link& link, Revision& out);
  void join(const Link& link, Revision& out);
  std::vector<int> members(std::uint32_t map) const;
  bool is_metric(const std::vector<int>& members) const;
  std::vector<Link> links_of(std::uint32_t map) const;
  void adjust_graph(std::uint32_t map);
  void adjust_loose();
  void adjust_bundles();
  void resize(Revision& out);
  std::set<std::uint32_t> moving() const;
  void tell(Revision& out);
};

void Revisit::State::add(const SettledKeyFrame& key_frame) {
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
  ++since_adjusted;
}

// Of a sub-map whose scale was measured before there was a key frame to correct by it.
bool Revisit::State::is_first_of_measured(const SettledKeyFrame& key_frame) const {
  return !map_of.contains(key_frame.pose.submap) && scales.contains(key_frame.pose.submap);
}

// Key frames of the newest one's map, or of all others, by the distance of their ground.
std::vector<int> Revisit::State::others(int newest, bool same_map) const {
  std::vector<std::pair<double, int>> found;
  const Vector3d centre = nodes[static_cast<std::size_t>(newest)].ground_centre();
  for (int i = 0; i < newest; ++i) {
    if ((map_at(i) == map_at(newest)) != same_map) continue;
    const Node& other = nodes[static_cast<std::size_t>(i)];
    if (!other.prior.known()) continue;
    found.emplace_back((other.ground_centre() - centre).norm(), i);
  }
  std::ranges::sort(found);
  std::vector<int> order;
  order.reserve(found.size());
  for (const auto& [distance, i] : found) order.push_back(i);
  return order;
}

// Earlier images that should overlap, by the map's own geometry and its uncertainty.
void Revisit::State::look_at_home(int newest) {
  const Node& own = node(newest);
  int tried = 0;
  for (const int i : others(newest, true)) {
    if (tried == config.candidates) break;
    if (node(i).submap == own.submap && newest - i < config.gap) continue;
    const double distance = (node(i).ground_centre() - own.ground_centre()).norm();
    const double way = swum[static_cast<std::size_t>(newest)] - swum[static_cast<std::size_t>(i)];
    const double footprint = own.footprint();
    if (distance > (kReach + 1) * footprint) break;
    if (distance > kReach * footprint + std::min(kDrift * way, footprint)) continue;
    ++tried;
    const auto is_this = [&](const Link& l) { return l.first == i && l.second == newest; };
    if (std::ranges::any_of(links, is_this)) continue;
    if (odometry::likeness(own.features, node(i).features) < kMinLikenessAtHome) continue;
    const auto found = link(nodes, i, newest);
    if (!found || !is_upright(*found)) continue;
    links.push_back(*found);
    loose.insert(map_at(newest));
  }
}

// Images of other maps that look alike.
void Revisit::State::look_abroad(int newest, Revision& out) {
  std::vector<int> order = others(newest, false);
  if (order.size() > kMostAlike) order.resize(kMostAlike);
  std::vector<std::pair<int, int>> alike;  // likeness, node
  for (const int i : order) {
    const int likeness = odometry::likeness(node(newest).features, node(i).features);
    if (likeness >= kMinLikeness) alike.emplace_back(-likeness, i);
  }
  std::ranges::sort(alike);
  if (alike.size() > kAbroad) alike.resize(kAbroad);
  for (const auto& [likeness, i] : alike) {
    const auto found = link(nodes, i, newest);
    if (found && is_upright(*found) && try_join(*found, out)) return;
  }
}

// The ground does not tilt between two visits.
bool Revisit::State::is_upright(const Link& link) const {
  const Similarity3 placed = first_from_second(link, nodes);
  const double tilt = std::acos(
      std::clamp((placed.rigid.rotation * Vector3d::UnitZ()).dot(Vector3d::UnitZ()), -1.0, 1.0));
  return tilt < config.max_tilt_deg * std::numbers::pi / 180;
}

bool Revisit::State::try_join(const Link& link, Revision& out) {
  const auto is_witness = [&](const Link& other) {
    return map_at(other.first) == map_at(link.first) &&
           map_at(other.second) == map_at(link.second) && other.second != link.second &&
           agree(link, other, nodes);
  };
  if (link.inliers < kSureJoin && std::ranges::none_of(unproven, is_witness)) {
    unproven.push_back(link);
    return false;
  }
  join(link, out);
  return true;
}

// The later map is moved onto the earlier.
void Revisit::State::join(const Link& link, Revision& out) {
  const std::uint32_t first = map_at(link.first), second = map_at(link.second);
  Similarity3 moved = first_from_second(link, nodes);
  const bool forward = first < second;
  if (!forward) moved = moved.inverse();
  const std::uint32_t kept = std::min(first, second), gone = std::max(first, second);
  const std::vector<int> earlier = members(kept), later = members(gone);
  if (is_metric(later) && !is_metric(earlier)) {  // only now the earlier one can be in metres
    const Similarity3 grown{1 / moved.scale, {}};
    for (const int i : earlier)
      node(i).corrected_from_camera = grown * node(i).corrected_from_camera;
    moved = grown * moved;
  }
  for (Node& n : nodes) {
    if (map_of.at(n.submap) == gone) n.corrected_from_camera = moved * n.corrected_from_camera;
  }
  for (auto& [submap, map] : map_of) {
    if (map == gone) map = kept;
  }
  links.push_back(link);
  const auto proven = [&](const Link& other) {
    return map_at(other.first) == map_at(other.second);
  };
  std::ranges::copy_if(unproven, std::back_inserter(links), [&](const Link& other) {
    return proven(other) && agree(link, other, nodes);
  });
  std::erase_if(unproven, proven);
  // Their common ground is known now: more pairs of images show it.
  constexpr std::size_t kMost = 20;
  for (std::size_t i = 0; i < std::min(kMost, later.size()); ++i) look_at_home(later[i]);
  loose.erase(gone);
  loose.insert(kept);
  since_adjusted = kPeriod;
  const int proof = forward ? link.second : link.first,
            witness = forward ? link.first : link.second;
  out.joins.push_back({gone, kept, node(proof).image, node(witness).image});
  out.alerts.push_back({time, node(proof).image, AlertKind::submap_joined,
                        "sub-map " + std::to_string(gone) + " was joined to sub-map " +
                            std::to_string(kept) + ": image " + std::to_string(node(proof).image) +
                            " shows the ground of image " + std::to_string(node(witness).image),
                        "none needed"});
}

std::vector<int> Revisit::State::members(std::uint32_t map) const {
  std::vector<int> found;
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    if (map_at(i) == map) found.push_back(i);
  }
  return found;
}

bool Revisit::State::is_metric(const std::vector<int>& members) const {
  return std::ranges::any_of(members,
                             [&](int i) { return nodes[static_cast<std::size_t>(i)].metric; });
}

std::vector<Link> Revisit::State::links_of(std::uint32_t map) const {
  std::vector<Link> found;
  std::ranges::copy_if(links, std::back_inserter(found),
                       [&](const Link& link) { return map_at(link.first) == map; });
  return found;
}

void Revisit::State::adjust_graph(std::uint32_t map) {
  const std::vector<int> own = members(map);
  if (own.empty()) return;
  std::vector<Edge> edges;
  for (std::size_t k = 1; k < own.size(); ++k) {
    if (node(own[k]).submap == node(own[k - 1]).submap) {
      edges.push_back(step(own[k - 1], own[k], nodes));
    }
  }
  for (const Link& link : links_of(map)) edges.push_back(edge_of(link, nodes));
  std::vector<Similarity3> poses;
  poses.reserve(nodes.size());
  for (const Node& n : nodes) poses.push_back(n.corrected_from_camera);
  if (!optimise(poses, edges, {own.front()})) return;
  for (const int i : own) node(i).corrected_from_camera = poses[static_cast<std::size_t>(i)];
}

void Revisit::State::adjust_loose() {
  for (const std::uint32_t map : loose) adjust_graph(map);
  loose.clear();
  since_adjusted = 0;
}

// With the pose graph's solution to start from.
void Revisit::State::adjust_bundles() {
  for (const std::uint32_t map : moving()) {
    const std::vector<Link> own_links = links_of(map);
    const std::vector<int> own = members(map);
    if (own_links.empty() || static_cast<int>(own.size()) > config.max_adjusted) continue;
    adjust_map(nodes, own, own_links);
  }
}

// Maps with links or measured scales.
std::set<std::uint32_t> Revisit::State::moving() const {
  std::set<std::uint32_t> maps;
  for (const Link& link : links) maps.insert(map_at(link.first));
  for (const auto& [submap, estimate] : scales) {
    if (map_of.contains(submap)) maps.insert(map_of.at(submap));
  }
  return maps;
}

// Every map as large as the measured scales of its sub-maps say, about the survey's origin.
void Revisit::State::resize(Revision& out) {
  struct Sum {
    double log_factor = 0, weight = 0;
    ScaleSource source = ScaleSource::none;
  };
  std::map<std::uint32_t, Sum> maps;
  for (const auto& [submap, estimate] : scales) {
    double logs = 0;
    int count = 0;
    for (const Node& n : nodes) {
      if (n.submap != submap || n.metric) continue;
      logs += std::log(n.corrected_from_camera.scale);
      ++count;
    }
    if (count == 0) continue;
    Sum& sum = maps[map_of.at(submap)];
    const double weight = 1 / (estimate.scale.sigma * estimate.scale.sigma);
    sum.log_factor += weight * (std::log(estimate.ratio) - logs / count);
    sum.weight += weight;
    sum.source = estimate.scale.source;
  }
  for (const auto& [map, sum] : maps) {
    if (is_metric(members(map))) continue;  // a pair knows better
    const Similarity3 by{std::exp(sum.log_factor / sum.weight), {}};
    const Scale scale{sum.source, 1 / std::sqrt(sum.weight)};
    for (Node& n : nodes) {
      if (map_of.at(n.submap) == map) n.corrected_from_camera = by * n.corrected_from_camera;
    }
    for (const auto& [submap, of] : map_of) {
      if (of == map) out.scales.emplace_back(submap, scale);
    }
  }
}

// What moved by more than can be seen, and every key frame that is new in a map that moves: the
// images up to the next key frame follow it.
void Revisit::State::tell(Revision& out) {
  constexpr double kVisible_px = 0.1;
  const std::set<std::uint32_t> maps = moving();
  for (const Node& n : nodes) {
    if (!maps.contains(map_of.at(n.submap))) continue;
    const Similarity3 now = n.corrected_from_live();
    const auto [known, is_new] = told.try_emplace(n.image, now);
    const Vector3d ground = n.live * Vector3d(0, 0, n.depth);
    const Vector3d centre = n.live.translation;
    const double moved = std::max((now * ground - known->second * ground).norm(),
                                  (now * centre - known->second * centre).norm());
    if (!is_new && moved < kVisible_px * now.scale * n.depth / n.rig->left.fx) continue;
    known->second = now;
    out.corrections.push_back({n.image, n.submap, now});
  }
}

Revisit::Revisit(Config config) : state_(std::make_unique<State>()) {
  config.check();
  state_->config = config;
}
Revisit::Revisit(Revisit&&) noexcept = default;
Revisit& Revisit::operator=(Revisit&&) noexcept = default;
Revisit::~Revisit() = default;

Revision Revisit::process(const Settlement& settlement) {
  Revision out;
  out.image = settlement.image;
  State& s = *state_;
  if (settlement.image) s.time = settlement.time;
  bool resize = !settlement.scales.empty();
  for (const auto& key_frame : settlement.key_frames) {
    resize = resize || s.is_first_of_measured(*key_frame);
    s.add(*key_frame);
    const int newest = static_cast<int>(s.nodes.size()) - 1;
    if (!s.config.enabled || !s.node(newest).prior.known()) continue;
    s.look_at_home(newest);
    s.look_abroad(newest, out);
  }
  const bool last = !settlement.image;
  if (!s.loose.empty() && (last || s.since_adjusted >= kPeriod)) s.adjust_loose();
  if (last) s.adjust_bundles();
  for (const ScaleEstimate& estimate : settlement.scales) s.scales[estimate.submap] = estimate;
  if (last || resize || !out.joins.empty()) s.resize(out);
  if (last || resize || !settlement.key_frames.empty()) s.tell(out);
  return out;
}

}  // namespace nadir::revisit
