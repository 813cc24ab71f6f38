// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nadir/core/rounded.hpp"

namespace nadir::app {

Finding check_rate(double rate_hz, double wanted_hz) {
  constexpr double kSlow = 0.7;
  const std::string found = rounded(rate_hz) + " images a second";
  if (wanted_hz > 0 && rate_hz < kSlow * wanted_hz) {
    return {Verdict::doubtful, "camera", found + " of " + rounded(wanted_hz) + " wanted",
            "more light, a fixed capture.exposure_ms or a faster format of the camera"};
  }
  return {Verdict::good, "camera", found};
}

Finding check_silence(std::chrono::seconds silence) {
  return {Verdict::bad, "camera",
          "has given no image for " + std::to_string(silence.count()) + " seconds",
          "check the camera and its cable; mapping goes on by itself"};
}

std::vector<Finding> check_picture(const Health& health) {
  const bool dark = health.has(Weakness::dark), bright = health.has(Weakness::bright);
  const bool blurred = health.has(Weakness::blurred);
  return {{dark || bright ? Verdict::doubtful : Verdict::good, "exposure",
           "mean grey level " + rounded(health.exposure, 0),
           dark     ? "more light, or a longer capture.exposure_ms"
           : bright ? "less light, or a shorter capture.exposure_ms"
                    : ""},
          {blurred ? Verdict::doubtful : Verdict::good, "focus",
           "sharpness " + rounded(health.sharpness, 0),
           blurred ? "clean the port, focus for the working distance under water, or look at "
                     "something with texture"
                   : ""}};
}

double blur_px(const Health& health, double weak_sharpness) {
  constexpr double kMost = 10;
  if (!(health.sharpness > 0)) return kMost;
  return std::min(kMost, std::sqrt(weak_sharpness / health.sharpness));
}

double motion_blur_px(double speed_px, double exposure_ms) {
  constexpr double kMilliseconds = 1000;
  return speed_px * exposure_ms / kMilliseconds;
}

Finding check_skew(std::optional<Time> skew, double most_ms) {
  if (!skew) {
    return {Verdict::doubtful, "stereo skew", "too few pairs to tell",
            "check that both cameras run at the same rate"};
  }
  const double skew_ms = 1e3 * seconds(*skew);
  const std::string found =
      "the right image " + rounded(skew_ms, 2) + " ms after the left one, by their stamps";
  if (std::abs(skew_ms) <= most_ms) return {Verdict::good, "stereo skew", found};
  return {Verdict::doubtful, "stereo skew", found, "trigger both cameras by one signal"};
}

Finding check_pair(const odometry::PairFit& fit) {
  constexpr double kGood_px = 1, kUsable_px = 3;  // corners are good to 0.6 px
  if (fit.matches < odometry::kEnoughMatches) {
    return {Verdict::doubtful, "stereo calibration",
            "only " + std::to_string(fit.matches) + " corners are seen by both cameras",
            "look at something with texture at the working distance"};
  }
  const std::string found = rounded(fit.epipolar_px, 2) + " px from the epipolar lines, of " +
                            std::to_string(fit.matches) + " corners the median";
  if (fit.epipolar_px <= kGood_px) return {Verdict::good, "stereo calibration", found};
  return {fit.epipolar_px <= kUsable_px ? Verdict::doubtful : Verdict::bad, "stereo calibration",
          found,
          "check that left and right are not swapped, that neither camera was moved, and that the "
          "calibration was made under water; nadir check-calibration tells more"};
}

Finding check_vehicle(const Frame& frame, const std::string& inputs, double convergence) {
  if (inputs.empty()) return {Verdict::absent, "sensors", "none configured (sensors.inputs)"};
  std::string known;
  const auto add = [&](const std::string& one) { known += (known.empty() ? "" : ", ") + one; };
  if (frame.attitude) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    const auto& [roll, pitch, yaw] = *frame.attitude;
    add("roll " + rounded(kDegrees * roll, 0) + ", pitch " + rounded(kDegrees * pitch, 0) +
        ", heading " + rounded(std::fmod(kDegrees * (yaw + convergence) + 360, 360), 0) +
        " degrees");
  }
  if (frame.depth) add("depth " + rounded(*frame.depth) + " m");
  if (frame.altitude) add("altitude " + rounded(*frame.altitude) + " m");
  if (!known.empty()) return {Verdict::good, "sensors", known};
  return {Verdict::doubtful, "sensors", "have nothing to tell of the image of now",
          "check the sensors, their power and cables, and sensors.inputs"};
}

}  // namespace nadir::app
