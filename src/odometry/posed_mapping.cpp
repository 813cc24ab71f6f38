// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "posed_mapping.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping.hpp"
#include "median.hpp"
#include "nadir/odometry/depth_prior.hpp"
#include "sighting.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kRadius = 4;      // px a tie point may lie from where a given pose puts it
constexpr double kMeet_px = 4;  // the same of a described corner, whose place is rougher
constexpr double kUnknownDisparity = 0.35;  // of the image width, searched when no depth is known

// Where two rays meet, in the map; none where they miss one another.
std::optional<Vector3d> meeting(const Map& map, const Bearing& a, const Bearing& b,
                                double tolerance_px) {
  const std::array<Bearing, 2> bearings{a, b};
  auto x = triangulate(bearings);
  if (!x) return std::nullopt;
  for (const Bearing& bearing : bearings) {
    const auto again = ray_of(bearing.camera_from_map * *x);
    if (!again || (*again - bearing.ray).norm() * map.rig->left.fx > tolerance_px)
      return std::nullopt;
  }
  return x;
}

struct Met {
  int host_feature = 0, target_feature = 0;
  double depth = 0;  ///< along the host's optical axis
};

std::vector<Met> met(const Map& map, const KeyFrame& from, const KeyFrame& to,
                     const Correspondences& matched) {
  std::vector<Met> result;
  for (const auto& [i, k] : matched.pairs) {
    const auto x =
        meeting(map, {from.camera_from_map, from.features.rays[static_cast<std::size_t>(i)]},
                {to.camera_from_map, to.features.rays[static_cast<std::size_t>(k)]}, kMeet_px);
    if (x) result.push_back({i, k, (from.camera_from_map * *x).z()});
  }
  return result;
}

// Sub-pixel in the target; none where it does not look alike or lies too far away to be placed.
std::optional<MapPoint> measured(const Map& map, int host, const Met& pair, const DepthPrior& prior,
                                 const Config& config) {
  const CameraModel& camera = map.rig->left;
  const KeyFrame& from = map.key_frame(host);
  const int target = static_cast<int>(map.key_frames.size()) - 1;
  const KeyFrame& to = map.last();
  const Vector2d& corner = from.features.pixels[static_cast<std::size_t>(pair.host_feature)];
  const Vector2d pixel = corner.array().round();
  const auto patch = cut_patch(from.view->frame->grey, pixel.cast<int>());
  const auto ray = camera.unproject(pixel);
  if (!patch || !ray) return std::nullopt;
  MapPoint point = new_point(map, host, pair.host_feature, pixel, *patch, prior.normal());
  point.x = from.camera_from_map.inverse() * (pair.depth * ray->homogeneous());
  const Vector2d start = to.features.pixels[static_cast<std::size_t>(pair.target_feature)];
  const auto found =
      sight(map, point, {to.view->frame->grey, camera, to.camera_from_map}, 2, start);
  const auto other = found ? camera.unproject(found->pixel) : std::nullopt;
  if (!other) return std::nullopt;
  const auto x = meeting(map, {from.camera_from_map, *ray}, {to.camera_from_map, *other}, 2);
  const double min_parallax = config.min_parallax_deg * M_PI / 180;
  if (!x || parallax(from.camera_from_map, to.camera_from_map, *x) < min_parallax)
    return std::nullopt;
  point.x = *x;
  point.sightings = {{host, *ray, {}}, {target, *other, {}}};
  return point;
}

}  // namespace

Resection measure_at(const Map& map, const View& view, const Rigid3& camera_from_map,
                     const Config& config) {
  Resection result;
  result.camera_from_map = camera_from_map;
  const Looking image{view.frame->grey, view.camera(), camera_from_map};
  const auto expected = expected_points(map, camera_from_map, config.tie_points);
  result.expected = static_cast<int>(expected.size());
  double squares = 0;
  for (const Expected& e : expected) {
    const auto found = sight(map, map.point(e.point), image, kRadius, e.pixel);
    if (!found || (found->pixel - e.pixel).norm() > kRadius) continue;
    const auto ray = view.camera().unproject(found->pixel);
    if (!ray) continue;
    result.seen.push_back({e.point, found->pixel, *ray});
    squares += (found->pixel - e.pixel).squaredNorm();
  }
  if (!result.seen.empty())
    result.rms_px = std::sqrt(squares / static_cast<double>(result.seen.size()));
  return result;
}

Connection connect(Map& map, int host, const Correspondences& matched, const Config& config) {
  const std::vector<Met> pairs = met(map, map.key_frame(host), map.last(), matched);
  std::vector<DepthSample> samples;
  for (const Met& pair : pairs) {
    const auto& rays = map.key_frame(host).features.rays;
    samples.push_back({rays[static_cast<std::size_t>(pair.host_feature)], 1 / pair.depth});
  }
  Connection result{static_cast<int>(pairs.size()), 0};
  const DepthPrior prior(std::move(samples));
  if (!prior.known()) return result;
  for (const Met& pair : pairs) {
    auto point = measured(map, host, pair, prior, config);
    if (!point) continue;
    insert(map, *std::move(point));
    ++result.inserted;
  }
  return result;
}

double rms_px(const Map& map, const KeyFrame& key_frame) {
  double squares = 0;
  int count = 0;
  for (const int i : key_frame.points) {
    const auto place = ray_of(key_frame.camera_from_map * map.point(i).x);
    for (const Sighting& s : map.point(i).sightings) {
      if (!place || map.key_frame(s.key_frame).image != key_frame.image) continue;
      squares += ((*place - s.ray) * map.rig->left.fx).squaredNorm();
      ++count;
    }
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

std::optional<PairScale> pair_scale(const Map& map, int key_frames) {
  constexpr std::size_t kFewest = 30;
  std::vector<double> ratios, disparities_px;
  const int count = static_cast<int>(map.key_frames.size());
  for (const MapPoint& point : map.points) {
    if (point.sightings.empty() || point.host < count - key_frames) continue;
    const KeyFrame& host = map.key_frame(point.host);
    if (!host.view || host.view->frame->right.empty()) continue;
    const auto& right = *host.view->frame->rig->right;
    const CameraModel& left = map.rig->left;
    const Vector2d pixel = point.host_pixel.cast<double>();
    const auto ray = left.unproject(pixel);
    if (!ray) continue;
    const double most =
        kUnknownDisparity * left.width / (left.fx * right.right_from_left.translation.norm());
    const Unplaced unplaced{point.patch, pixel, *ray,
                            0,           most,  host.camera_from_map.rotation * point.normal};
    const auto found = search_epipolar_line(unplaced, left, right.camera, right.right_from_left,
                                            host.view->frame->right, 1);
    if (!found) continue;
    const std::array<Bearing, 2> bearings{{{{}, *ray}, {right.right_from_left, found->ray}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    ratios.push_back(x->z() / (host.camera_from_map * point.x).z());
    disparities_px.push_back(left.fx * right.right_from_left.translation.norm() / x->z());
  }
  if (ratios.size() < kFewest) return std::nullopt;
  const double metres = median(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio / metres - 1);
  // Of the median of a normal distribution, from its median deviation.
  constexpr double kSigmaOfDeviation = 1.4826, kSigmaOfMedian = 1.2533;
  const double own = kSigmaOfDeviation * kSigmaOfMedian * median(ratios) /
                     std::sqrt(static_cast<double>(ratios.size()));
  return PairScale{metres, std::hypot(own, kSharedMatching_px / median(disparities_px))};
}

}  // namespace nadir::odometry
