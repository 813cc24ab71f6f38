// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "exposure_control.hpp"

#include <algorithm>
#include <cmath>

namespace nadir::capture {
namespace {

constexpr double kWanted = 105, kTolerance = 0.15;  // grey level; lamps' hot spots stay below white
constexpr double kGamma = 2.2;                      // of usual cameras: light to grey level
constexpr double kMostStep = 4;                     // of light at once
constexpr double kGainStep = 1.0 / 16;              // of its range, for twice the light
constexpr double kOfPeriod = 0.9;                   // the sensor needs the rest to be read

}  // namespace

ExposureControl::ExposureControl(const ExposureRange& range, double max_blur_px,
                                 const Exposure& begin)
    : range_(range), max_blur_px_(max_blur_px), exposure_(begin) {}

double ExposureControl::longest_ms(double speed_px, double period_ms) const {
  double longest = std::min(range_.longest_ms, kOfPeriod * period_ms);
  constexpr double kMilliseconds = 1000;
  if (speed_px > 0) longest = std::min(longest, kMilliseconds * max_blur_px_ / speed_px);
  return std::max(longest, range_.shortest_ms);
}

std::optional<Exposure> ExposureControl::observe(double mean_grey, double speed_px,
                                                 double period_ms) {
  const double longest = longest_ms(speed_px, period_ms);
  const bool smears = exposure_.ms > 1.1 * longest;  // not for each change of speed
  if (settling_ > 0 && --settling_ > 0 && !smears) return std::nullopt;
  // How much more light is wanted.
  const double wanted =
      std::clamp(std::pow(kWanted / std::max(mean_grey, 1.0), kGamma), 1 / kMostStep, kMostStep);
  const bool dark = mean_grey < kWanted * (1 - kTolerance);
  const bool bright = mean_grey > kWanted * (1 + kTolerance);
  if (!dark && !bright && !smears) return std::nullopt;

  Exposure next = exposure_;
  const double gain_step =
      kGainStep * (range_.most_gain - range_.least_gain) * std::abs(std::log2(wanted));
  if (bright && next.gain > range_.least_gain) {
    next.gain = std::max(next.gain - gain_step, range_.least_gain);
  } else if (dark || bright) {
    next.ms = exposure_.ms * wanted;
    if (dark && exposure_.ms >= 0.95 * longest)
      next.gain = std::min(next.gain + gain_step, range_.most_gain);
  }
  next.ms = std::clamp(next.ms, range_.shortest_ms, longest);
  // What the motion takes of the exposure, gain has to give.
  if (smears && !bright) next.gain = std::min(next.gain + gain_step, range_.most_gain);
  if (next == exposure_) return std::nullopt;
  exposure_ = next;
  settling_ = range_.delay;
  return next;
}

}  // namespace nadir::capture
