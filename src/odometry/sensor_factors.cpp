// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_factors.hpp"

#include <algorithm>
#include <cmath>

#include "sensor_errors.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Quaterniond, Eigen::Vector2d, Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

struct Near {
  int point = 0;
  double distance = 0;  ///< of the rays
  double depth = 0;
};

// The tie points around a laser's dot say how far the ground is there.
std::vector<Near> around(const Map& map, const KeyFrame& key_frame, int index, const Range& range) {
  constexpr std::size_t kMost = 6;
  constexpr double kReach = 0.1;
  std::vector<Near> found;
  for (const int i : key_frame.points) {
    const MapPoint& point = map.point(i);
    const auto seen = std::find_if(point.sightings.begin(), point.sightings.end(),
                                   [&](const Sighting& s) { return s.key_frame == index; });
    if (seen == point.sightings.end()) continue;
    const double distance = (seen->ray - range.ray).norm();
    const double depth = (key_frame.camera_from_map * point.x).z();
    if (distance < kReach && depth > 0) found.push_back({i, distance, depth});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Near& a, const Near& b) { return a.distance < b.distance; });
  if (found.size() > kMost) found.resize(kMost);
  return found;
}

bool is_metric(const Map& map) { return map.scale.source != ScaleSource::none; }

// A pair measures every depth itself.
bool takes_ranges(const Map& map) { return is_metric(map) && !map.rig->right; }

Quaterniond turned(const Quaterniond& map_from_camera, double about_up) {
  return Quaterniond(Eigen::AngleAxisd(about_up, Vector3d::UnitZ())) * map_from_camera;
}

void add_ranges(const Map& map, int index, int image, const std::vector<int>& points, double sigma,
                Adjustment& a) {
  const KeyFrame& key_frame = map.key_frame(index);
  for (const Range& range : key_frame.ranges) {
    const auto near = around(map, key_frame, index, range);
    const double of_all = std::hypot(sigma, range.sigma);
    for (const Near& n : near) {
      const auto place = std::lower_bound(points.begin(), points.end(), n.point);
      if (place == points.end() || *place != n.point) continue;
      a.ranges.push_back({image, static_cast<int>(place - points.begin()),
                          range.depth * std::exp(map.range_offset.mean()),
                          of_all * std::sqrt(static_cast<double>(near.size()))});
    }
  }
}

}  // namespace

std::optional<Quaterniond> enu_from_camera(const Frame& frame) {
  if (!frame.attitude) return std::nullopt;
  static const Quaterniond kEnuFromNed(Eigen::Matrix3d{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}});
  return kEnuFromNed * frame.attitude->ned_from_body() * frame.rig->body_from_camera;
}

void add_sensor_factors(const Map& map, const std::vector<int>& key_frames,
                        const std::vector<int>& points, const Config& config, Adjustment& a) {
  for (int i = 0; i < static_cast<int>(key_frames.size()); ++i) {
    const int index = key_frames[static_cast<std::size_t>(i)];
    const KeyFrame& k = map.key_frame(index);
    const bool heading = map.axes == SurveyAxes::attitude && map.heading_offset.is_known();
    // Roll and pitch of the held key frames, too: of the map's own vertical, which may be its
    // seabed's and not the AHRS's, only the differences count.
    if (k.enu_from_camera && config.attitude_sigma_deg > 0) {
      a.verticals.push_back({i, k.enu_from_camera->conjugate() * Vector3d::UnitZ(),
                             config.attitude_sigma_deg * kDegree});
    }
    if (a.images[static_cast<std::size_t>(i)].fixed) continue;
    if (k.enu_from_camera && heading && config.heading_sigma_deg > 0) {
      a.headings.push_back({i, turned(*k.enu_from_camera, map.heading_offset.mean()),
                            config.heading_sigma_deg * kDegree});
    }
    if (k.height && is_metric(map) && map.height_offset.is_known() && config.depth_sigma_m > 0) {
      a.heights.push_back({i, *k.height + map.height_offset.mean(), config.depth_sigma_m});
    }
    if (takes_ranges(map) && map.range_offset.is_known() && config.range_sigma > 0) {
      add_ranges(map, index, i, points, config.range_sigma, a);
    }
  }
}

void learn_offsets(Map& map, const KeyFrame& key_frame, int index) {
  if (key_frame.enu_from_camera && map.axes == SurveyAxes::attitude) {
    const Quaterniond as_known = turned(*key_frame.enu_from_camera, map.heading_offset.mean());
    const double error = heading_error(as_known, key_frame.camera_from_map);
    map.heading_offset.add(map.heading_offset.mean() + error);
  }
  if (!is_metric(map)) return;
  if (key_frame.height) {
    map.height_offset.add(key_frame.camera_from_map.inverse().translation.z() - *key_frame.height);
  }
  if (!takes_ranges(map)) return;
  double logs = 0;
  int count = 0;
  for (const Range& range : key_frame.ranges) {
    for (const Near& n : around(map, key_frame, index, range)) {
      logs += std::log(n.depth / range.depth);
      ++count;
    }
  }
  if (count > 0) map.range_offset.add(logs / count);
}

}  // namespace nadir::odometry
