// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "mapping.hpp"

#include <algorithm>
#include <cmath>

#include "sensor_factors.hpp"
#include "sighting.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kUnknownDisparity = 0.35;  // of the image width, searched when no depth is known

// Which cells of an image still want a tie point.
class Coverage {
 public:
  Coverage(const CameraModel& camera, int wanted)
      : side_(std::sqrt(camera.width * camera.height / static_cast<double>(wanted))),
        columns_(static_cast<int>(camera.width / side_) + 1),
        taken_(static_cast<std::size_t>(columns_ * (static_cast<int>(camera.height / side_) + 1)),
               0) {}
  bool free(const Vector2d& pixel) const { return taken_[index(pixel)] == 0; }
  void take(const Vector2d& pixel) { taken_[index(pixel)] = 1; }

 private:
  std::size_t index(const Vector2d& pixel) const {
    const int i =
        static_cast<int>(pixel.y() / side_) * columns_ + static_cast<int>(pixel.x() / side_);
    return static_cast<std::size_t>(std::clamp(i, 0, static_cast<int>(taken_.size()) - 1));
  }
  double side_;
  int columns_;
  std::vector<char> taken_;
};

Coverage covered(const Map& map, const KeyFrame& key_frame, int wanted) {
  Coverage coverage(map.rig->left, wanted);
  for (const int i : key_frame.points) {
    const auto pixel = map.rig->left.project(key_frame.camera_from_map * map.point(i).x);
    if (pixel) coverage.take(*pixel);
  }
  return coverage;
}

std::optional<Unplaced> unplaced(const KeyFrame& host, const CameraModel& camera, int feature,
                                 const DepthPrior& prior) {
  const Vector2d pixel =
      host.features.pixels[static_cast<std::size_t>(feature)].array().round().matrix();
  const auto patch = cut_patch(host.view->frame->grey, pixel.cast<int>());
  const auto ray = camera.unproject(pixel);
  if (!patch || !ray) return std::nullopt;
  const auto guess = prior.at(*ray);
  return Unplaced{*patch,
                  pixel,
                  *ray,
                  guess.inverse_depth - guess.spread,
                  guess.inverse_depth + guess.spread,
                  prior.normal()};
}

// Tie points of the last key frame by its right image.
void add_stereo_points(Map& map, const Config& config) {
  const int host = static_cast<int>(map.key_frames.size()) - 1;
  const KeyFrame& key_frame = map.last();
  const auto& right = *map.rig->right;
  const DepthPrior prior = depth_prior(map, key_frame);
  Coverage coverage = covered(map, key_frame, config.tie_points);
  const double baseline = right.right_from_left.translation.norm();
  for (int i = 0; i < key_frame.features.size(); ++i) {
    if (!coverage.free(key_frame.features.pixels[static_cast<std::size_t>(i)])) continue;
    auto point = unplaced(key_frame, map.rig->left, i, prior);
    if (!point) continue;
    if (!prior.known()) {
      point->inverse_depth_min = 0;
      point->inverse_depth_max =
          kUnknownDisparity * map.rig->left.width / (map.rig->left.fx * baseline);
    }
    const auto found = search_epipolar_line(*point, map.rig->left, right.camera,
                                            right.right_from_left, key_frame.view->frame->right, 1);
    if (!found) continue;
    const std::array<Bearing, 2> bearings{{{{}, point->ray}, {right.right_from_left, found->ray}}};
    const auto x = triangulate(bearings);
    if (!x) continue;
    const auto again = ray_of(*x);
    if (!again || (*again - point->ray).norm() * map.rig->left.fx > 1.0) continue;
    MapPoint created = new_point(map, host, i, point->pixel, point->patch, point->normal_in_host);
    created.x = key_frame.camera_from_map.inverse() * *x;
    created.sightings.push_back({host, point->ray, found->ray});
    coverage.take(point->pixel);
    insert(map, std::move(created));
  }
}

// Tie points of an earlier key frame's corners found again in the last one.
void add_points_between(Map& map, int host, Coverage& coverage, const Config& config) {
  const int target = static_cast<int>(map.key_frames.size()) - 1;
  const KeyFrame& from = map.key_frame(host);
  const KeyFrame& to = map.key_frame(target);
  const CameraModel& camera = map.rig->left;
  const DepthPrior prior = depth_prior(map, from);
  if (!prior.known()) return;
  const Rigid3 target_from_host = to.camera_from_map * from.camera_from_map.inverse();
  const Coverage known = covered(map, from, 4 * config.tie_points);
  const double min_parallax = config.min_parallax_deg * M_PI / 180;
  for (int i = 0; i < from.features.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!known.free(from.features.pixels[k])) continue;
    const Vector3d guess =
        from.features.rays[k].homogeneous() / prior.at(from.features.rays[k]).inverse_depth;
    const auto place = camera.project(target_from_host * guess);
    if (!place || place->x() < 8 || place->y() < 8 || place->x() > camera.width - 9 ||
        place->y() > camera.height - 9 || !coverage.free(*place))
      continue;
    if (parallax({}, target_from_host, guess) < 0.8 * min_parallax) continue;
    const auto point = unplaced(from, camera, i, prior);
    if (!point) continue;
    const auto found =
        search_epipolar_line(*point, camera, camera, target_from_host, to.view->frame->grey, 1);
    if (!found) continue;
    const std::array<Bearing, 2> bearings{
        {{from.camera_from_map, point->ray}, {to.camera_from_map, found->ray}}};
    const auto x = triangulate(bearings);
    if (!x || parallax(from.camera_from_map, to.camera_from_map, *x) < min_parallax) continue;
    const auto again = ray_of(from.camera_from_map * *x);
    if (!again || (*again - point->ray).norm() * camera.fx > 1.0) continue;
    MapPoint created = new_point(map, host, i, point->pixel, point->patch, point->normal_in_host);
    created.x = *x;
    created.sightings = {{host, point->ray, {}}, {target, found->ray, {}}};
    coverage.take(found->sight.pixel);
    insert(map, std::move(created));
  }
}

// The same view without its right image.
std::shared_ptr<const View> left_of(const View& pair) {
  auto frame = std::make_shared<Frame>(*pair.frame);
  frame->right.release();
  auto left = std::make_shared<View>(pair);
  left->frame = std::move(frame);
  return left;
}

}  // namespace

MapPoint new_point(const Map& map, int host, int feature, const Vector2d& pixel, const Patch& patch,
                   const Vector3d& normal_in_host) {
  const KeyFrame& key_frame = map.key_frame(host);
  MapPoint point;
  point.host = host;
  point.host_pixel = pixel.array().round().cast<int>();
  point.patch = patch;
  point.normal = key_frame.camera_from_map.rotation.conjugate() * normal_in_host;
  const std::uint8_t* row = key_frame.features.descriptors.ptr(feature);
  std::copy(row, row + 32, point.descriptor.begin());
  const auto& bgr =
      key_frame.view->frame->colour.at<cv::Vec3b>(point.host_pixel.y(), point.host_pixel.x());
  point.rgb = {bgr[2], bgr[1], bgr[0]};
  return point;
}

void insert(Map& map, MapPoint point) {
  const int index = static_cast<int>(map.points.size());
  for (const Sighting& s : point.sightings) map.key_frame(s.key_frame).points.push_back(index);
  map.points.push_back(std::move(point));
}

bool is_foreign(const InRight& right) {
  constexpr int kEnough = 30;
  // Rendered pairs that fit find 90 % and more, whatever their relief; frozen, late, black and
  // knocked ones 6 % at most, 4 px too low 45 to 61 %.
  constexpr double kMinShare = 0.6;
  return right.looked_for >= kEnough && right.found < kMinShare * right.looked_for;
}

InRight add_key_frame(Map& map, std::shared_ptr<const View> view, const Resection& resection) {
  const int index = static_cast<int>(map.key_frames.size());
  KeyFrame key_frame;
  key_frame.image = view->frame->image;
  key_frame.time = view->frame->time;
  key_frame.camera_from_map = resection.camera_from_map;
  key_frame.features = view->features;
  key_frame.enu_from_camera = enu_from_camera(*view->frame);
  if (view->frame->depth) key_frame.height = -*view->frame->depth;
  key_frame.ranges = view->frame->ranges;
  key_frame.view = std::move(view);
  key_frame.rms_px = resection.rms_px;
  key_frame.depth = map.key_frames.empty() ? 0 : map.last().depth;
  map.key_frames.push_back(std::move(key_frame));
  const bool pair = map.rig->right && !map.last().view->frame->right.empty();
  InRight in_right;
  std::vector<Sighting> sightings;
  for (const Seen& s : resection.seen) {
    Sighting sighting{index, s.ray, {}};
    if (pair) {
      const auto& right = *map.rig->right;
      const Looking image{map.last().view->frame->right, right.camera,
                          right.right_from_left * resection.camera_from_map};
      ++in_right.looked_for;
      if (const auto found = sight(map, map.point(s.point), image, 2)) {
        sighting.right_ray = right.camera.unproject(found->pixel);
        ++in_right.found;
      }
    }
    sightings.push_back(sighting);
  }
  if (is_foreign(in_right)) {
    map.key_frames.back().view = left_of(*map.last().view);
    for (Sighting& sighting : sightings) sighting.right_ray.reset();
  }
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const int point = resection.seen[i].point;
    map.point(point).sightings.push_back(sightings[i]);
    map.key_frames.back().points.push_back(point);
  }
  return in_right;
}

void add_tie_points(Map& map, const Config& config) {
  if (map.rig->right && !map.last().view->frame->right.empty()) {
    add_stereo_points(map, config);
    return;
  }
  Coverage coverage = covered(map, map.last(), config.tie_points);
  constexpr int kHosts = 2;  // the overlap with earlier ones is part of theirs
  const int target = static_cast<int>(map.key_frames.size()) - 1;
  for (int host = target - 1; host >= std::max(0, target - kHosts); --host) {
    if (!map.key_frame(host).view) break;
    add_points_between(map, host, coverage, config);
  }
}

}  // namespace nadir::odometry
