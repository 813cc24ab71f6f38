// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "mapping.hpp"

#include <algorithm>
#include <cmath>

#include "depth_prior.hpp"
#include "sighting.hpp"
#include "triangulation.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kOutlier_px = 2.0;
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

void add_key_frame(Map& map, std::shared_ptr<const View> view, const Resection& resection) {
  const int index = static_cast<int>(map.key_frames.size());
  KeyFrame key_frame;
  key_frame.image = view->frame->image;
  key_frame.time = view->frame->time;
  key_frame.camera_from_map = resection.camera_from_map;
  key_frame.features = view->features;
  key_frame.view = std::move(view);
  key_frame.rms_px = resection.rms_px;
  key_frame.depth = map.key_frames.empty() ? 0 : map.last().depth;
  map.key_frames.push_back(std::move(key_frame));
  const bool pair = map.rig->right && !map.last().view->frame->right.empty();
  for (const Seen& s : resection.seen) {
    Sighting sighting{index, s.ray, {}};
    if (pair) {
      const auto& right = *map.rig->right;
      const Looking image{map.last().view->frame->right, right.camera,
                          right.right_from_left * resection.camera_from_map};
      if (const auto found = sight(map, map.point(s.point), image, 2)) {
        sighting.right_ray = right.camera.unproject(found->pixel);
      }
    }
    map.point(s.point).sightings.push_back(sighting);
    map.key_frames.back().points.push_back(s.point);
  }
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

AdjustmentSummary adjust_window(Map& map, int window, int fixed) {
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
  const AdjustmentSummary summary = adjust(a, *map.rig);
  if (!summary.usable) return summary;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    map.key_frame(images[i]).camera_from_map = a.images[i].camera_from_map;
  }
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
    if (!a.images[i].fixed) key_frame.rms_px = by_image[i].rms();
  }
  return summary;
}

void retire(Map& map, const Config& config) {
  const int count = static_cast<int>(map.key_frames.size());
  const int view_end = count - config.window;
  for (int k = view_end - 1; k >= 0 && map.key_frame(k).view; --k) map.key_frame(k).view.reset();
  const int feature_end = count - std::max(config.window, config.relocalise_key_frames);
  for (int k = feature_end - 1; k >= 0 && map.key_frame(k).features.size() > 0; --k) {
    map.key_frame(k).features = {};
  }
}

ImagePose pose_of(const Map& map, const KeyFrame& k) {
  return {k.image,    k.time,
          map.submap, k.camera_from_map.inverse(),
          true,       static_cast<std::uint32_t>(k.points.size()),
          k.rms_px};
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
