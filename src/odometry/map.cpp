// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "map.hpp"

#include <algorithm>

namespace nadir::odometry {
namespace {

// Key frames farther than this many depths from a camera share no ground with it.
constexpr double kReachInDepths = 2.0;
constexpr int kMargin = Template::kRadius + 2;

}  // namespace

void move(Map& map, const Similarity3& to_from_map) {
  for (KeyFrame& key_frame : map.key_frames) {
    key_frame.camera_from_map = (to_from_map * key_frame.camera_from_map.inverse()).inverse();
    key_frame.depth *= to_from_map.scale;
    key_frame.sigma_position *= to_from_map.scale;
  }
  for (MapPoint& point : map.points) {
    point.x = to_from_map * point.x;
    point.normal = to_from_map.rigid.rotation * point.normal;
  }
}

void give_up(Map& map, int point) {
  for (const Sighting& s : map.point(point).sightings) {
    std::erase(map.key_frame(s.key_frame).points, point);
  }
  map.point(point).sightings.clear();
  map.given_up.push_back(point);
}

void give_up_sighting(Map& map, int point, int key_frame) {
  std::erase_if(map.point(point).sightings,
                [&](const Sighting& s) { return s.key_frame == key_frame; });
  std::erase(map.key_frame(key_frame).points, point);
}

double median_depth(const Map& map, const KeyFrame& key_frame) {
  std::vector<double> depths;
  for (const int i : key_frame.points) {
    depths.push_back((key_frame.camera_from_map * map.point(i).x).z());
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

DepthPrior depth_prior(const Map& map, const KeyFrame& key_frame) {
  std::vector<DepthSample> samples;
  for (const int i : key_frame.points) {
    const Eigen::Vector3d x = key_frame.camera_from_map * map.point(i).x;
    if (x.z() > 0) samples.push_back({x.head<2>() / x.z(), 1 / x.z()});
  }
  return DepthPrior(std::move(samples));
}

std::vector<Expected> expected_points(const Map& map, const Rigid3& camera_from_map, int limit) {
  const CameraModel& camera = map.rig->left;
  const Eigen::Vector3d centre = camera_from_map.inverse().translation;
  std::vector<char> known(map.points.size(), 0);
  std::vector<Expected> found;
  for (auto key_frame = map.key_frames.rbegin(); key_frame != map.key_frames.rend(); ++key_frame) {
    const double reach = kReachInDepths * key_frame->depth;
    if ((key_frame->camera_from_map.inverse().translation - centre).norm() > reach) continue;
    for (const int i : key_frame->points) {
      if (std::exchange(known[static_cast<std::size_t>(i)], 1) != 0) continue;
      const auto pixel = camera.project(camera_from_map * map.point(i).x);
      if (!pixel || pixel->x() < kMargin || pixel->y() < kMargin ||
          pixel->x() > camera.width - 1 - kMargin || pixel->y() > camera.height - 1 - kMargin)
        continue;
      found.push_back({i, *pixel});
    }
  }
  std::stable_sort(found.begin(), found.end(), [&](const Expected& a, const Expected& b) {
    return map.point(a.point).sightings.size() > map.point(b.point).sightings.size();
  });
  const double side = std::sqrt(camera.width * camera.height * 3.0 / limit);
  const int columns = static_cast<int>(camera.width / side) + 1;
  const int rows = static_cast<int>(camera.height / side) + 1;
  std::vector<int> taken(static_cast<std::size_t>(columns * rows), 0);
  std::erase_if(found, [&](const Expected& e) {
    const int cell =
        static_cast<int>(e.pixel.y() / side) * columns + static_cast<int>(e.pixel.x() / side);
    return ++taken[static_cast<std::size_t>(cell)] > 4;
  });
  if (static_cast<int>(found.size()) > limit) found.resize(static_cast<std::size_t>(limit));
  return found;
}

}  // namespace nadir::odometry
