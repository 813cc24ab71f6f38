// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether a camera's exposure can be steered, within what, and where that begins.
#pragma once

#include <algorithm>

#include "libcamera_plugin.h"

namespace nadir::capture {

/// Of a control; not numbers where the camera does not tell.
struct Bounds {
  double least, most;
};

/// frame_us: of the mode in use; 0: unknown. Not steered when a fixed exposure is wanted or a bound
/// is missing. A fixed gain stays, as near as the camera can.
inline NadirExposing steering(const Bounds& exposure_us, const Bounds& gain, double frame_us,
                              const NadirCameraWanted& wanted) {
  // A row of a sensor takes about so long. To Raspberry Pi's algorithms 0 means: by itself, of gain
  // too.
  constexpr double kShortest_us = 20, kLeastGain = 1;
  // Where neither the frame nor, as on a Raspberry Pi, the control sets a bound.
  constexpr double kUsualFrame_us = 100'000;
  // How light it is, nobody knows before the first image. Lamps at a usual distance ask for about
  // so much, and in daylight four images a factor of four are soon done. Never more than half a
  // frame, so that both ways are open; gain is noise.
  constexpr double kBegin_us = 8000;

  const double longest_us = std::min(exposure_us.most, frame_us > 0 ? frame_us : kUsualFrame_us);
  const double shortest_us = std::max(exposure_us.least, kShortest_us);
  const double least_gain = gain.least > 0 ? gain.least : kLeastGain;
  // Not numbers compare false.
  const bool bounded = exposure_us.least <= exposure_us.most && gain.least <= gain.most;
  if (wanted.exposure_ms > 0 || !bounded || shortest_us >= longest_us || least_gain > gain.most)
    return {};
  constexpr double kMs = 1e-3;
  NadirExposing found{};
  found.steered = 1;
  found.shortest_ms = kMs * shortest_us;
  found.longest_ms = kMs * longest_us;
  found.least_gain = least_gain;
  found.most_gain = gain.most;
  if (wanted.gain >= 0)
    found.least_gain = found.most_gain = std::clamp(wanted.gain, least_gain, gain.most);
  found.ms = kMs * std::max(std::min(kBegin_us, longest_us / 2), shortest_us);
  found.gain = found.least_gain;
  return found;
}

}  // namespace nadir::capture
