// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "health.hpp"

namespace nadir::odometry {

Health health_of(const View& view) {
  Health health;
  health.sharpness = view.sharpness;
  health.exposure = view.exposure;
  return health;
}

void count(Health& health, const Resection& resection, const CameraModel& camera) {
  health.tie_points = static_cast<std::uint32_t>(resection.seen.size());
  health.rms_px = resection.rms_px;
  for (const Seen& s : resection.seen) {
    const std::size_t right = s.pixel.x() > 0.5 * camera.width ? 1 : 0;
    const std::size_t bottom = s.pixel.y() > 0.5 * camera.height ? 2 : 0;
    ++health.by_quadrant[bottom + right];
  }
}

}  // namespace nadir::odometry
