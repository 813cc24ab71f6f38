// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "loss.hpp"

#include <string>

namespace nadir::odometry {
namespace {

void tell_why_blank(const View& view, const Config& config, Alert& alert) {
  if (view.exposure < config.weak_dark) {
    alert.message += "too dark (blank image): lamps off, or no seabed within their reach";
    alert.remedy = "check the lamps, expose longer or go closer to the seabed";
  } else if (view.exposure > config.weak_bright) {
    alert.message += "over-exposed (blank image)";
    alert.remedy = "expose for less time, dim the lamps or keep them farther from the seabed";
  } else {
    alert.message += "nothing to see but silt or open water (blank image)";
    alert.remedy = "let silt settle or go closer to the seabed; check that the lens is clear";
  }
}

}  // namespace

Alert no_map_alert(const Frame& last) {
  return {last.time, last.image, AlertKind::tracking_lost,
          "no map could be started: too few images, or no motion between them",
          "take more images while moving over the ground, with at least 60 % overlap"};
}

Alert no_map_yet_alert(const Frame& newest, StartTrouble trouble) {
  Alert alert{newest.time,
              newest.image,
              AlertKind::tracking_lost,
              "image " + std::to_string(newest.image) + ": no map yet: ",
              {}};
  if (trouble == StartTrouble::no_motion) {
    alert.message += "the camera hardly moves over the ground";
    alert.remedy = "move on over the ground; the map starts by itself";
  } else {
    alert.message += "the images do not fit each other as views of one ground";
    alert.remedy =
        "move sideways over the ground, with at least 60 % overlap; check the calibration with "
        "nadir check-calibration";
  }
  return alert;
}

Alert loss_alert(const View& view, LossReason reason, const Config& config) {
  const Frame& frame = *view.frame;
  Alert alert{frame.time,
              frame.image,
              AlertKind::tracking_lost,
              "image " + std::to_string(frame.image) + ": ",
              {}};
  switch (reason) {
    case LossReason::blank_image:
      tell_why_blank(view, config, alert);
      break;
    case LossReason::too_few_matches:
      alert.message += "too few matches with the images before";
      alert.remedy = "go back over the last good ground, slower and with more overlap";
      break;
    case LossReason::too_large_motion:
      alert.message += "does not overlap the images before (too large a motion)";
      alert.remedy = "go back to the last good view, then move on slower";
      break;
  }
  return alert;
}

}  // namespace nadir::odometry
