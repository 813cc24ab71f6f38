// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Time is integer nanoseconds until printed; the zero is the survey's own (timestamps.csv), the
// UNIX epoch, or of live cameras and sensors that of CLOCK_MONOTONIC.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace nadir {

using Time = std::int64_t;

constexpr double seconds(Time time) { return static_cast<double>(time) / 1e9; }
inline Time from_seconds(double s) { return static_cast<Time>(std::llround(s * 1e9)); }
/// Now, of live cameras and sensors: steady_clock is CLOCK_MONOTONIC.
inline Time monotonic_now() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace nadir
