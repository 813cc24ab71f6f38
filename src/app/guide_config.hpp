// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What is to be surveyed, and how: settings of the guidance.
#pragma once

#include <optional>

#include "nadir/coverage/lanes.hpp"
#include "nadir/reference/geodetic.hpp"

namespace nadir::app {

/// A rectangle to be covered; none when length is 0.
struct PlanConfig {
  double length = 0, width = 0;                      ///< metres
  double bearing_deg = 0;                            ///< of the length, clockwise from survey y
  double lane_spacing = 0;                           ///< metres; 0: 0.7 of a footprint's width
  double corner_x = 0, corner_y = 0;                 ///< metres in the survey
  double corner_latitude = 0, corner_longitude = 0;  ///< degrees, in their place; 0 and 0: not

  bool is_placed_on_earth() const { return corner_latitude != 0 || corner_longitude != 0; }
  /// Throws InputError naming the setting and its range.
  void check() const;
};

/// grid: around reference.origin, if that is set. None without a plan. Throws InputError when the
/// corner is a position on the earth that the grid does not have within 100 km.
std::optional<coverage::Plan> planned(const PlanConfig& config,
                                      const std::optional<reference::UtmGrid>& grid);

struct GuideConfig {
  double altitude_low = 0, altitude_high = 0;  ///< metres; 0: by the usual footprint
  double overlap_low = 0.6;                    ///< share

  void check() const;
};

}  // namespace nadir::app
