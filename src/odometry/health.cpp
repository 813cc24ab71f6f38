// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "health.hpp"

#include <algorithm>
#include <vector>

namespace nadir::odometry {
namespace {

class TiePoints {
 public:
  explicit TiePoints(const CameraModel& camera) : camera_(camera) {}

  void add(const Eigen::Vector2d& pixel, std::size_t images) {
    const std::size_t right = pixel.x() > 0.5 * camera_.width ? 1 : 0;
    const std::size_t bottom = pixel.y() > 0.5 * camera_.height ? 2 : 0;
    ++by_quadrant_[bottom + right];
    lengths_.push_back(images);
  }

  void judge(double rms_px, const Config& config, Health& health) {
    health.tie_points = static_cast<std::uint32_t>(lengths_.size());
    health.by_quadrant = by_quadrant_;
    health.rms_px = rms_px;
    if (!lengths_.empty()) {
      const auto middle = lengths_.begin() + static_cast<std::ptrdiff_t>(lengths_.size() / 2);
      std::nth_element(lengths_.begin(), middle, lengths_.end());
      health.tracked_length = static_cast<double>(*middle);
    }
    const auto least = *std::min_element(by_quadrant_.begin(), by_quadrant_.end());
    const auto below = [](std::uint32_t count, int wanted) {
      return static_cast<int>(count) < wanted;
    };
    if (below(health.tie_points, config.weak_tie_points)) health.add(Weakness::few_tie_points);
    if (below(least, config.weak_quadrant)) health.add(Weakness::one_sided);
    if (health.tracked_length < config.weak_track_length) health.add(Weakness::short_tracks);
    if (rms_px > config.weak_rms_px) health.add(Weakness::large_residuals);
  }

 private:
  const CameraModel& camera_;
  std::array<std::uint32_t, 4> by_quadrant_{};
  std::vector<std::size_t> lengths_;
};

}  // namespace

Health health_of(const View& view, const Config& config) {
  Health health;
  health.sharpness = view.sharpness;
  health.exposure = view.exposure;
  if (view.sharpness < config.weak_sharpness) health.add(Weakness::blurred);
  if (view.exposure < config.weak_dark) health.add(Weakness::dark);
  if (view.exposure > config.weak_bright) health.add(Weakness::bright);
  return health;
}

void count(Health& health, const Map& map, const Resection& resection, const Config& config) {
  TiePoints seen(map.rig->left);
  for (const Seen& s : resection.seen) seen.add(s.pixel, map.point(s.point).sightings.size() + 1);
  seen.judge(resection.rms_px, config, health);
}

void count(Health& health, const Map& map, int key_frame, const Config& config) {
  TiePoints seen(map.rig->left);
  for (const int i : map.key_frame(key_frame).points) {
    const auto& sightings = map.point(i).sightings;
    const auto here = std::find_if(sightings.begin(), sightings.end(),
                                   [&](const Sighting& s) { return s.key_frame == key_frame; });
    if (here == sightings.end()) continue;
    const auto pixel = map.rig->left.project(here->ray.homogeneous());
    if (pixel) seen.add(*pixel, sightings.size());
  }
  seen.judge(map.key_frame(key_frame).rms_px, config, health);
}

void tell(const Health& health, const View& view, Orientation& out) {
  if (out.shot && out.shot->image == view.frame->image) {
    out.health = health;
  } else {
    out.later_health.push_back({view.frame->image, health});
  }
}

void tell_health(const Map& map, int key_frame, const Config& config, Orientation& out) {
  const View& view = *map.key_frame(key_frame).view;
  Health health = health_of(view, config);
  count(health, map, key_frame, config);
  tell(health, view, out);
}

}  // namespace nadir::odometry
