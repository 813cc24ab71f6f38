// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a self-calibration says against the calibration it started from.
#include <cmath>
#include <cstdio>
#include <string>

#include "nadir/odometry/self_calibration.hpp"

namespace nadir::odometry {
namespace {

std::string text(const char* format, double a, double b = 0, double c = 0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

// Neighbouring errors are alike, so that an adjustment thinks itself better than it is.
constexpr double kSure = 5;  // sigma

bool is_sure(double difference, double sigma) { return std::abs(difference) > kSure * sigma; }

void doubt_lens(const LensFit& lens, const std::string& camera, std::vector<Alert>& out) {
  const auto add = [&](const std::string& message, std::string remedy) {
    out.push_back({0, std::nullopt, AlertKind::calibration_suspect, camera + ": " + message,
                   std::move(remedy)});
  };
  constexpr double kFocalOff = 0.02;
  // Water makes a flat port's focal length 1.33 times as long.
  constexpr double kWaterFrom = 1.2, kWaterTo = 1.45;
  const auto [ratio, sigma] = lens.focal_ratio;
  if (std::abs(ratio - 1) > kFocalOff && is_sure(ratio - 1, sigma)) {
    const bool air = ratio > kWaterFrom && ratio < kWaterTo;
    add(text("the images ask for a focal length %.3f times as long (+- %.3f)", ratio, sigma) +
            (air ? ", as water behind a flat port makes it: the calibration seems made in air"
                 : ""),
        "calibrate under water, with the same port, focus and zoom");
    if (air) return;  // the rest is wrong with it
  }
  constexpr double kBent_px = 0.3;
  const auto [bent, bent_sigma] = lens.distortion_px;
  if (bent > kBent_px && is_sure(bent, bent_sigma)) {
    add(text("the distortion is off by up to %.2f px (+- %.2f) somewhere on the image", bent,
             bent_sigma),
        "calibrate again, with the board up to the corners and all of k1, k2, p1, p2 and k3");
  }
}

void doubt_pair(const PairFit& pair, std::vector<Alert>& out) {
  constexpr double kApart_px = 0.3, kBetter = 2;
  if (pair.epipolar_px - pair.refined_epipolar_px > kApart_px &&
      pair.epipolar_px > kBetter * pair.refined_epipolar_px) {
    out.push_back({0, std::nullopt, AlertKind::calibration_suspect,
                   text("the pair: right corners lie %.2f px from their epipolar lines, and could "
                        "lie within %.2f px",
                        pair.epipolar_px, pair.refined_epipolar_px),
                   "calibrate the pair again, the cameras fixed to each other as they are now"});
  }
  constexpr double kLate_s = 0.002;
  const auto [delay, sigma] = pair.delay_s;
  if (sigma > 0 && std::abs(delay) > kLate_s && is_sure(delay, sigma)) {
    out.push_back(
        {0, std::nullopt, AlertKind::stereo_skew,
         text("right images are taken %.1f ms (+- %.1f) after the left ones", 1e3 * delay,
              1e3 * sigma),
         "trigger both cameras by one signal; check that pairs are not shifted by an image"});
  }
}

}  // namespace

std::vector<Alert> doubts(const CalibrationFit& fit) {
  std::vector<Alert> all;
  doubt_lens(fit.left, fit.right ? "left camera" : "camera", all);
  if (fit.right) doubt_lens(*fit.right, "right camera", all);
  if (fit.pair) doubt_pair(*fit.pair, all);
  return all;
}

}  // namespace nadir::odometry
