// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Headings.
#pragma once

#include <cmath>
#include <numbers>

namespace nadir::sensors {

inline constexpr double kTurn = 2 * std::numbers::pi;

/// The same direction within [0, 2 pi).
inline double as_heading(double angle) {
  const double rest = angle - kTurn * std::floor(angle / kTurn);
  return rest < kTurn ? rest : 0;
}

}  // namespace nadir::sensors
