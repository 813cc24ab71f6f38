// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "loss.hpp"

#include <string>

namespace nadir::odometry {

Alert no_map_alert(const Frame& last) {
  return {last.time, last.image, AlertKind::tracking_lost,
          "no map could be started: too few images, or no motion between them",
          "take more images while moving over the ground, with at least 60 % overlap"};
}

Alert loss_alert(const Frame& frame, LossReason reason) {
  Alert alert{frame.time, frame.image, AlertKind::tracking_lost, {}, {}};
  const std::string image = "image " + std::to_string(frame.image) + ": ";
  switch (reason) {
    case LossReason::blank_image:
      alert.message = image + "nothing to see (blank image)";
      alert.remedy = "check lamps and lens, let silt settle or go closer to the seabed";
      break;
    case LossReason::too_few_matches:
      alert.message = image + "too few matches with the images before";
      alert.remedy = "go back over the last good ground, slower and with more overlap";
      break;
    case LossReason::too_large_motion:
      alert.message = image + "does not overlap the images before (too large a motion)";
      alert.remedy = "go back to the last good view, then move on slower";
      break;
  }
  return alert;
}

}  // namespace nadir::odometry
