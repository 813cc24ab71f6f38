// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nadir/core/key_frame.hpp"
#include "nadir/image_io/encode.hpp"
#include "pose_covariance.hpp"
#include "sensor_factors.hpp"

namespace nadir::odometry {
namespace {

constexpr double kOutlier_px = 2.0;

std::shared_ptr<const SettledKeyFrame> settled(Map& map, KeyFrame& key_frame, int index) {
  auto result = std::make_shared<SettledKeyFrame>();
  result->pose = pose_of(map, key_frame);
  result->axes = map.axes;
  result->rig = map.rig;
  result->features = std::exchange(key_frame.features, {});
  result->picture = std::exchange(key_frame.picture, {});
  for (const int i : key_frame.points) {
    const MapPoint& point = map.point(i);
    const auto s = std::find_if(point.sightings.begin(), point.sightings.end(),
                                [&](const Sighting& seen) { return seen.key_frame == index; });
    if (s == point.sightings.end()) continue;
    result->observations.push_back(
        {map.first_id + static_cast<std::uint64_t>(i), s->ray, s->right_ray, point.x});
  }
  return result;
}

// How well each free key frame is known relative to the one before it.
void estimate_sigmas(const Adjustment& a, const std::vector<int>& key_frames, Map& map) {
  const auto covariance = PoseCovariance::of(a, *map.rig, AdjustmentOptions().robust_px);
  if (!covariance) return;
  for (int i = 0; i < static_cast<int>(key_frames.size()); ++i) {
    const int k = key_frames[static_cast<std::size_t>(i)];
    const auto before = std::find(key_frames.begin(), key_frames.end(), k - 1);
    if (a.images[static_cast<std::size_t>(i)].fixed || before == key_frames.end()) continue;
    const Sigmas sigmas =
        sigmas_of(covariance->relative(a, static_cast<int>(before - key_frames.begin()), i));
    map.key_frame(k).sigma_position = sigmas.position;
    map.key_frame(k).sigma_rotation = sigmas.rotation;
  }
}

void let_view_die(KeyFrame& key_frame) {
  if (!key_frame.view) return;
  constexpr int kQuality = 80;
  const auto jpeg = image_io::encode_jpeg(small_picture(key_frame.view->frame->grey), kQuality);
  key_frame.picture.assign(jpeg.begin(), jpeg.end());  // of its own size
  key_frame.view.reset();
}

// Key frames up to `end` that were not handed out before.
Settled settle(Map& map, int end) {
  Settled result;
  for (; map.settled < end; ++map.settled) {
    KeyFrame& key_frame = map.key_frame(map.settled);
    let_view_die(key_frame);
    result.push_back(settled(map, key_frame, map.settled));
  }
  return result;
}

}  // namespace

AdjustmentSummary adjust_window(Map& map, int window, int fixed, const Config& config) {
  const int count = static_cast<int>(map.key_frames.size());
  const int first_free = std::max(fixed, count - window);
  Adjustment a;
  std::vector<int> image_of(map.key_frames.size(), -1), images, points;
  const auto image = [&](int key_frame) {
    int& index = image_of[static_cast<std::size_t>(key_frame)];
    if (index < 0) {
      index = static_cast<int>(a.images.size());
      // With one camera and only the first image held, the second holds the scale.
      const bool scale = key_frame == 1 && first_free == 1 && !map.rig->right;
      a.images.push_back({map.key_frame(key_frame).camera_from_map, key_frame < first_free, scale});
      images.push_back(key_frame);
    }
    return index;
  };
  for (int k = std::max(0, count - window); k < count; ++k) {
    points.insert(points.end(), map.key_frame(k).points.begin(), map.key_frame(k).points.end());
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  for (const int i : points) {
    const int index = static_cast<int>(a.points.size());
    a.points.push_back({map.point(i).x, false});
    for (const Sighting& s : map.point(i).sightings) {
      a.observations.push_back({image(s.key_frame), index, false, s.ray});
      if (s.right_ray) a.observations.push_back({image(s.key_frame), index, true, *s.right_ray});
    }
  }
  add_sensor_factors(map, images, points, config, a);
  const AdjustmentSummary summary = adjust(a, *map.rig);
  if (!summary.usable) return summary;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    map.key_frame(images[i]).camera_from_map = a.images[i].camera_from_map;
  }
  estimate_sigmas(a, images, map);
  struct Sum {
    double squares = 0;
    int count = 0;
    void add(double error) { squares += error * error, ++count; }
    double rms() const { return count > 0 ? std::sqrt(squares / count) : 0; }
  };
  std::vector<Sum> by_point(points.size()), by_image(a.images.size());
  for (std::size_t i = 0; i < points.size(); ++i) map.point(points[i]).x = a.points[i].x_in_map;
  for (const auto& o : a.observations) {
    const int point = points[static_cast<std::size_t>(o.point)];
    const int key_frame = images[static_cast<std::size_t>(o.image)];
    if (o.error_px < kOutlier_px) {
      by_point[static_cast<std::size_t>(o.point)].add(o.error_px);
      by_image[static_cast<std::size_t>(o.image)].add(o.error_px);
    } else if (o.right) {
      for (Sighting& s : map.point(point).sightings) {
        if (s.key_frame == key_frame) s.right_ray.reset();
      }
    } else {
      give_up_sighting(map, point, key_frame);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    MapPoint& point = map.point(points[i]);
    point.rms_px = by_point[i].rms();
    std::size_t rays = point.sightings.size();
    for (const Sighting& s : point.sightings) rays += s.right_ray ? 1 : 0;
    if (rays < 2) give_up(map, points[i]);
  }
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    KeyFrame& key_frame = map.key_frame(images[i]);
    key_frame.depth = median_depth(map, key_frame);
    const bool is_new = key_frame.rms_px == 0;  // the first of all is never free
    if (is_new || !a.images[i].fixed) key_frame.rms_px = by_image[i].rms();
  }
  return summary;
}

Settled retire(Map& map, const Config& config) {
  const int count = static_cast<int>(map.key_frames.size());
  const int view_end = count - config.window;
  for (int k = view_end - 1; k >= 0 && map.key_frame(k).view; --k) {
    learn_offsets(map, map.key_frame(k), k);
    let_view_die(map.key_frame(k));
  }
  return settle(map, count - std::max(config.window, config.relocalise_key_frames));
}

Settled retire_all(Map& map) { return settle(map, static_cast<int>(map.key_frames.size())); }

ImagePose pose_of(const Map& map, const KeyFrame& k) {
  return {k.image,
          k.time,
          map.submap,
          k.camera_from_map.inverse(),
          true,
          static_cast<std::uint32_t>(k.points.size()),
          k.rms_px,
          k.sigma_position,
          k.sigma_rotation};
}

Window make_window(const Map& map, int window, const AdjustmentSummary& summary) {
  Window result;
  result.submap = map.submap;
  result.scale = map.scale;
  result.axes = map.axes;
  result.uncertain = map.uncertain;
  result.rms_px = summary.rms_px;
  result.iterations = summary.iterations;
  result.converged = summary.converged;
  const std::size_t first =
      map.key_frames.size() - std::min(map.key_frames.size(), static_cast<std::size_t>(window));
  std::vector<int> points;
  for (std::size_t k = first; k < map.key_frames.size(); ++k) {
    const KeyFrame& key_frame = map.key_frames[k];
    result.images.push_back(pose_of(map, key_frame));
    points.insert(points.end(), key_frame.points.begin(), key_frame.points.end());
  }
  result.central = map.key_frames[first + result.images.size() / 2].view->frame;
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  for (const int i : points) {
    const MapPoint& p = map.point(i);
    result.tie_points.push_back({map.first_id + static_cast<std::uint64_t>(i), p.x, p.rgb,
                                 static_cast<std::uint32_t>(p.sightings.size()), p.rms_px});
  }
  return result;
}

}  // namespace nadir::odometry
