// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/revisit/revisit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "map_adjustment.hpp"
#include "nadir/odometry/calibration_monitor.hpp"
#include "pose_graph.hpp"
#include "recognition.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;

constexpr int kPeriod = 10;  // key frames between adjustments of the pose graph

// Errors of odometry from one key frame to the next, and of a revisit: what they weigh against each
// other. Of corners in half a pixel, and of depths guessed from the neighbourhood.
constexpr double kStepRotation = 5e-4, kStepTranslation = 1e-3, kStepScale = 1e-3;
constexpr double kLinkRotation = 2e-3, kLinkTranslation = 4e-3, kLinkScale = 1e-2;
constexpr double kKnownScale = 1e-6;

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

}  // namespace

struct Revisit::State {
  Config config;
  odometry::CalibrationMonitor calibration;
  Maps maps;
  std::map<std::uint32_t, ScaleEstimate> scales;  ///< measured, by sub-map
  std::map<std::uint64_t, Similarity3> told;      ///< by image
  int since_adjusted = 0;                         ///< key frames
  Time time = 0;                                  ///< of the newest shot

  void look(int newest, Revision& out);
  bool is_first_of_measured(const SettledKeyFrame& key_frame) const;
  void adjust_graph(std::uint32_t map);
  void adjust_loose();
  void adjust_bundles();
  void resize(Revision& out);
  std::set<std::uint32_t> moving() const;
  void tell(Revision& out);
};

void Revisit::State::look(int newest, Revision& out) {
  if (!config.enabled || !maps.node(newest).prior.known()) return;
  const std::size_t joins = out.joins.size();
  look_at_home(maps, newest, config);
  look_abroad(maps, newest, config, time, out);
  if (out.joins.size() > joins) since_adjusted = kPeriod;
}

// Of a sub-map whose scale was measured before there was a key frame to correct by it.
bool Revisit::State::is_first_of_measured(const SettledKeyFrame& key_frame) const {
  return !maps.map_of.contains(key_frame.pose.submap) && scales.contains(key_frame.pose.submap);
}

void Revisit::State::adjust_graph(std::uint32_t map) {
  const std::vector<int> own = maps.members(map);
  if (own.empty()) return;
  std::vector<Edge> edges;
  for (std::size_t k = 1; k < own.size(); ++k) {
    if (maps.node(own[k]).submap == maps.node(own[k - 1]).submap) {
      edges.push_back(step(own[k - 1], own[k], maps.nodes));
    }
  }
  for (const Link& link : maps.links_of(map)) edges.push_back(edge_of(link, maps.nodes));
  std::vector<Similarity3> poses;
  poses.reserve(maps.nodes.size());
  for (const Node& n : maps.nodes) poses.push_back(n.corrected_from_camera);
  if (!optimise(poses, edges, {own.front()})) return;
  for (const int i : own) maps.node(i).corrected_from_camera = poses[static_cast<std::size_t>(i)];
}

void Revisit::State::adjust_loose() {
  for (const std::uint32_t map : maps.loose) adjust_graph(map);
  maps.loose.clear();
  since_adjusted = 0;
}

// With the pose graph's solution to start from.
void Revisit::State::adjust_bundles() {
  for (const std::uint32_t map : moving()) {
    const std::vector<Link> own_links = maps.links_of(map);
    const std::vector<int> own = maps.members(map);
    if (own_links.empty() || static_cast<int>(own.size()) > config.max_adjusted) continue;
    adjust_map(maps.nodes, own, own_links);
  }
}

// Maps with links or measured scales.
std::set<std::uint32_t> Revisit::State::moving() const {
  std::set<std::uint32_t> found;
  for (const Link& link : maps.links) found.insert(maps.map_at(link.first));
  for (const auto& [submap, estimate] : scales) {
    if (maps.map_of.contains(submap)) found.insert(maps.map_of.at(submap));
  }
  return found;
}

// Every map as large as the measured scales of its sub-maps say, about the survey's origin.
void Revisit::State::resize(Revision& out) {
  struct Sum {
    double log_factor = 0, weight = 0, largest = 0;
    ScaleSource source = ScaleSource::none;
  };
  std::map<std::uint32_t, Sum> sums;  // by map
  for (const auto& [submap, estimate] : scales) {
    double logs = 0;
    int count = 0;
    for (const Node& n : maps.nodes) {
      if (n.submap != submap || n.metric) continue;
      logs += std::log(n.corrected_from_camera.scale);
      ++count;
    }
    if (count == 0) continue;
    Sum& sum = sums[maps.map_of.at(submap)];
    const double weight = 1 / (estimate.scale.sigma * estimate.scale.sigma);
    sum.log_factor += weight * (std::log(estimate.ratio) - logs / count);
    sum.weight += weight;
    if (weight > sum.largest) sum.source = estimate.scale.source;
    sum.largest = std::max(sum.largest, weight);
  }
  for (const auto& [map, sum] : sums) {
    if (maps.is_metric(maps.members(map))) continue;  // a pair knows better
    const Similarity3 by{std::exp(sum.log_factor / sum.weight), {}};
    // A sensor's own error is the same in all of its sub-maps: they know no more than the best one.
    const Scale scale{sum.source, 1 / std::sqrt(sum.largest)};
    for (Node& n : maps.nodes) {
      if (maps.map_of.at(n.submap) == map) n.corrected_from_camera = by * n.corrected_from_camera;
    }
    for (const auto& [submap, of] : maps.map_of) {
      if (of == map) out.scales.emplace_back(submap, scale);
    }
  }
}

// What moved by more than can be seen, and every key frame that is new in a map that moves: the
// images up to the next key frame follow it.
void Revisit::State::tell(Revision& out) {
  constexpr double kVisible_px = 0.1;
  const std::set<std::uint32_t> moving_maps = moving();
  for (const Node& n : maps.nodes) {
    if (!moving_maps.contains(maps.map_of.at(n.submap))) continue;
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
    s.maps.add(*key_frame);
    if (!s.config.enabled) s.maps.nodes.back().picture = {};
    ++s.since_adjusted;
    s.look(static_cast<int>(s.maps.nodes.size()) - 1, out);
  }
  const bool last = !settlement.image;
  if (s.config.check_calibration) {
    std::ranges::move(s.calibration.observe(settlement.key_frames, last),
                      std::back_inserter(out.alerts));
  }
  if (last && s.config.enabled) look_all_over(s.maps, s.config, s.time, out);
  if (!s.maps.loose.empty() && (last || s.since_adjusted >= kPeriod)) s.adjust_loose();
  if (last) s.adjust_bundles();
  for (const ScaleEstimate& estimate : settlement.scales) s.scales[estimate.submap] = estimate;
  if (last || resize || !out.joins.empty()) s.resize(out);
  if (last || resize || !settlement.key_frames.empty()) s.tell(out);
  return out;
}

}  // namespace nadir::revisit
