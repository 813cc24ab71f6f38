// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "map_adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "nadir/odometry/bundle_adjustment.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;

// A tie point is seen to a tenth of a pixel, a corner of a revisit to half of one; but its error is
// the same at all its points, so that it weighs more than its share.
constexpr double kCornerWeight = 0.5;

// The bundle in the frame of the first member's camera.
class Bundle {
 public:
  Bundle(const std::vector<Node>& nodes, const std::vector<int>& members);
  void add(const Link& link, const std::vector<Node>& nodes);
  bool solve();
  /// Where a member's camera is, and how its lengths grew.
  Similarity3 corrected_from_camera(std::size_t member, const Node& node) const;

 private:
  int point_of(const TiePointObservation& observation, const Node& node);

  Rigid3 map_from_survey_;
  CameraRig rig_;
  odometry::Adjustment bundle_;
  std::unordered_map<std::uint64_t, int> points_;  // by id
  std::unordered_map<int, int> images_;            // by node
};

Bundle::Bundle(const std::vector<Node>& nodes, const std::vector<int>& members) {
  const Node& first = nodes[static_cast<std::size_t>(members.front())];
  map_from_survey_ = first.corrected_from_camera.rigid.inverse();
  rig_ = *first.rig;
  for (const int member : members) {
    const Node& node = nodes[static_cast<std::size_t>(member)];
    if (node.metric) rig_ = *node.rig;
  }
  double farthest = 0;
  std::size_t anchor = 0;
  bool metric = false;
  for (const int member : members) {
    const Node& node = nodes[static_cast<std::size_t>(member)];
    const int image = static_cast<int>(bundle_.images.size());
    images_[member] = image;
    const Rigid3 pose = map_from_survey_ * node.corrected_from_camera.rigid;
    if (pose.translation.norm() > farthest) {
      farthest = pose.translation.norm();
      anchor = static_cast<std::size_t>(image);
    }
    metric = metric || node.metric;
    bundle_.images.push_back({pose.inverse(), image == 0, false});
    for (const TiePointObservation& o : node.observations) {
      const int point = point_of(o, node);
      bundle_.observations.push_back({image, point, false, o.ray});
      if (o.right_ray) bundle_.observations.push_back({image, point, true, *o.right_ray});
    }
  }
  // Of one camera the scale is free: the farthest key frame keeps it.
  if (!metric && anchor > 0) bundle_.images[anchor].distance_fixed = true;
}

// Its place as it was last known.
int Bundle::point_of(const TiePointObservation& observation, const Node& node) {
  const auto [known, is_new] =
      points_.try_emplace(observation.tie_point, static_cast<int>(bundle_.points.size()));
  const Vector3d x = map_from_survey_ * (node.corrected_from_live() * observation.x_in_survey);
  if (is_new) bundle_.points.push_back({x, false});
  bundle_.points[static_cast<std::size_t>(known->second)].x_in_map = x;
  return known->second;
}

void Bundle::add(const Link& link, const std::vector<Node>& nodes) {
  const Node& first = nodes[static_cast<std::size_t>(link.first)];
  for (const CrossSighting& s : link.sightings) {
    const auto& seen = first.observations[static_cast<std::size_t>(s.observation)];
    bundle_.observations.push_back(
        {images_.at(link.second), points_.at(seen.tie_point), false, s.ray, kCornerWeight});
  }
  for (const CommonCorner& corner : link.corners) {
    const int point = static_cast<int>(bundle_.points.size());
    const Eigen::Vector3d x = first.corrected_from_camera * corner.x_in_first;
    bundle_.points.push_back({map_from_survey_ * x, false});
    bundle_.observations.push_back(
        {images_.at(link.first), point, false, corner.first, kCornerWeight});
    bundle_.observations.push_back(
        {images_.at(link.second), point, false, corner.second, kCornerWeight});
  }
}

// Few corners join what thousands of tie points hold: their share of the cost is small.
bool Bundle::solve() { return odometry::adjust(bundle_, rig_, {1.0, 40, 1e-7}).usable; }

Similarity3 Bundle::corrected_from_camera(std::size_t member, const Node& node) const {
  const Rigid3& camera_from_map = bundle_.images[member].camera_from_map;
  const Rigid3 camera_from_survey = node.live.inverse();
  std::vector<double> ratios;
  for (const TiePointObservation& o : node.observations) {
    const auto& x = bundle_.points[static_cast<std::size_t>(points_.at(o.tie_point))].x_in_map;
    const double before = (camera_from_survey * o.x_in_survey).z();
    const double now = (camera_from_map * x).z();
    if (before > 0 && now > 0) ratios.push_back(now / before);
  }
  double scale = node.corrected_from_camera.scale;
  if (!ratios.empty() && !node.metric) {
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    scale = *middle;
  }
  return {scale, map_from_survey_.inverse() * camera_from_map.inverse()};
}

}  // namespace

bool adjust_map(std::vector<Node>& nodes, const std::vector<int>& members,
                const std::vector<Link>& links) {
  Bundle bundle(nodes, members);
  for (const Link& link : links) bundle.add(link, nodes);
  if (!bundle.solve()) return false;
  for (std::size_t i = 0; i < members.size(); ++i) {
    Node& node = nodes[static_cast<std::size_t>(members[i])];
    node.corrected_from_camera = bundle.corrected_from_camera(i, node);
  }
  return true;
}

}  // namespace nadir::revisit
