// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "initialisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping.hpp"
#include "nadir/odometry/depth_prior.hpp"
#include "relative_orientation.hpp"
#include "sighting.hpp"
#include "triangulation.hpp"
#include "window.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kMinPoints = 50;  // of a map worth starting
constexpr double kMaxRms_px = 1.0;      // a false map fits worse
constexpr double kMinParallax = 1.0 * M_PI / 180;

// Ground depths in the first camera, from corners alone.
std::vector<std::pair<int, double>> corner_depths(const Rays& first, const Rays& second,
                                                  const Rigid3& motion, double tolerance) {
  std::vector<std::pair<int, double>> depths;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::array<Bearing, 2> bearings{{{{}, first[i]}, {motion, second[i]}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    const auto a = ray_of(*x);
    if (a && (*a - first[i]).norm() < tolerance) depths.emplace_back(static_cast<int>(i), x->z());
  }
  return depths;
}

Map map_of(const std::shared_ptr<const View>& view) {
  Map map;
  map.rig = view->frame->rig;
  add_key_frame(map, view, {});
  return map;
}

// Sub-pixel tie points of two oriented images from their matched corners.
void add_matched(Map& map, const Correspondences& matched, const DepthPrior& prior) {
  const CameraModel& camera = map.rig->left;
  const KeyFrame& first = map.key_frame(0);
  const KeyFrame& second = map.key_frame(1);
  for (const auto& [i, k] : matched.pairs) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(k);
    const Vector2d pixel = first.features.pixels[a].array().round();
    const auto patch = cut_patch(first.view->frame->grey, pixel.cast<int>());
    const auto ray = camera.unproject(pixel);
    if (!patch || !ray) continue;
    const Vector3d x = ray->homogeneous() / prior.at(*ray).inverse_depth;
    const auto affine =
        local_affine(camera, {}, pixel, x, prior.normal(), camera, second.camera_from_map);
    if (!affine) continue;
    const auto wanted = warp_patch(*patch, *affine);
    if (!wanted) continue;
    const Vector2d start = second.features.pixels[b] + *affine * (pixel - first.features.pixels[a]);
    const auto found = refine(*wanted, second.view->frame->grey,
                              search(*wanted, second.view->frame->grey, start, 2).pixel);
    if (!found || found->correlation < 0.8) continue;
    const auto other = camera.unproject(found->pixel);
    if (!other) continue;
    const std::array<Bearing, 2> bearings{{{{}, *ray}, {second.camera_from_map, *other}}};
    const auto placed = triangulate(bearings);
    if (!placed) continue;
    MapPoint point = new_point(map, 0, i, pixel, *patch, prior.normal());
    point.x = *placed;
    point.sightings = {{0, *ray, {}}, {1, *other, {}}};
    insert(map, std::move(point));
  }
}

std::optional<Map> seed(const std::shared_ptr<const View>& first,
                        const std::shared_ptr<const View>& second, const Correspondences& matched,
                        const Rays& a, const Rays& b, Rigid3 motion, const Config& config) {
  const double tolerance = 10 * corner_sigma(first->camera());
  auto depths = corner_depths(a, b, motion, tolerance);
  if (depths.size() < kMinPoints / 2) return std::nullopt;
  std::vector<double> sorted;
  sorted.reserve(depths.size());
  for (const auto& d : depths) sorted.push_back(d.second);
  std::sort(sorted.begin(), sorted.end());
  const double unit = sorted[sorted.size() / 2];
  std::vector<DepthSample> samples;
  samples.reserve(depths.size());
  for (const auto& [i, depth] : depths) {
    samples.push_back({a[static_cast<std::size_t>(i)], unit / depth});
  }
  const DepthPrior prior(std::move(samples));
  if (!prior.known()) return std::nullopt;
  motion.translation /= unit;
  Map map = map_of(first);
  Resection resection;
  resection.camera_from_map = motion;
  add_key_frame(map, second, resection);
  add_matched(map, matched, prior);
  if (!adjust_window(map, 2, 1, config).usable) return std::nullopt;
  add_tie_points(map, config);
  if (!adjust_window(map, 2, 1, config).usable) return std::nullopt;
  return map;
}

// Orients the images from `next` on against the map and adds them; false when one does not fit.
bool extend(Map& map, std::span<const std::shared_ptr<const View>> views, std::size_t next,
            const Config& config) {
  for (; next < views.size(); ++next) {
    const std::array references{static_cast<int>(map.key_frames.size()) - 1};
    const auto result = resect(map, *views[next], std::nullopt, references, config);
    if (!result.resection) return false;
    add_key_frame(map, views[next], *result.resection);
    add_tie_points(map, config);
    const auto summary = adjust_window(map, static_cast<int>(views.size()), 1, config);
    if (!summary.usable || summary.rms_px > kMaxRms_px) return false;
  }
  return true;
}

std::size_t sightings(const Map& map) {
  std::size_t count = 0;
  for (const MapPoint& p : map.points) count += p.sightings.size();
  return count;
}

bool sound(const Map& map) {
  std::vector<double> angles;
  for (const MapPoint& p : map.points) {
    if (p.sightings.empty()) continue;
    const Rigid3& a = map.key_frame(p.sightings.front().key_frame).camera_from_map;
    const Rigid3& b = map.key_frame(p.sightings.back().key_frame).camera_from_map;
    angles.push_back(map.rig->right ? kMinParallax : parallax(a, b, p.x));
  }
  if (angles.size() < kMinPoints) return false;
  std::sort(angles.begin(), angles.end());
  return angles[angles.size() / 2] >= kMinParallax;
}

}  // namespace

std::optional<Map> start_map(std::span<const std::shared_ptr<const View>> views,
                             const Config& config) {
  std::optional<Map> best;
  const auto consider = [&](std::optional<Map> map, std::size_t next) {
    if (!map || !extend(*map, views, next, config) || !sound(*map)) return;
    if (!best || sightings(*map) > sightings(*best)) best = std::move(map);
  };
  const CameraRig& rig = *views[0]->frame->rig;
  if (rig.right && !views[0]->frame->right.empty()) {
    Map map = map_of(views[0]);
    add_tie_points(map, config);
    map.key_frame(0).depth = median_depth(map, map.last());
    consider(std::move(map), 1);
    return best;
  }
  const auto matched = correspond(views[0]->features, views[1]->features, rig.left);
  Rays a, b;
  for (const auto& [i, k] : matched.pairs) {
    a.push_back(views[0]->features.rays[static_cast<std::size_t>(i)]);
    b.push_back(views[1]->features.rays[static_cast<std::size_t>(k)]);
  }
  for (const auto& o : relative_orientations(a, b, rig.left, corner_sigma(rig.left))) {
    consider(seed(views[0], views[1], matched, a, b, o.second_from_first, config), 2);
  }
  return best;
}

}  // namespace nadir::odometry
