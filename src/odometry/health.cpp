// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "health.hpp"

namespace nadir::odometry {

Health health_of(const View& view, const Config& config) {
  Health health;
  health.sharpness = view.sharpness;
  health.exposure = view.exposure;
  if (view.sharpness < config.weak_sharpness) health.add(Weakness::blurred);
  if (view.exposure < config.weak_dark) health.add(Weakness::dark);
  if (view.exposure > config.weak_bright) health.add(Weakness::bright);
  return health;
}

void count(Health& health, const Resection& resection, const CameraModel& camera,
           const Config& config) {
  health.tie_points = static_cast<std::uint32_t>(resection.seen.size());
  health.rms_px = resection.rms_px;
  for (const Seen& s : resection.seen) {
    const std::size_t right = s.pixel.x() > 0.5 * camera.width ? 1 : 0;
    const std::size_t bottom = s.pixel.y() > 0.5 * camera.height ? 2 : 0;
    ++health.by_quadrant[bottom + right];
  }
  // Nothing was expected of the first image whose pose was given.
  if (resection.expected > 0 && static_cast<int>(resection.seen.size()) < config.weak_tie_points) {
    health.add(Weakness::few_tie_points);
  }
  if (resection.rms_px > config.weak_rms_px) health.add(Weakness::large_residuals);
}

}  // namespace nadir::odometry
