// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "guide_config.hpp"

#include <cmath>
#include <numbers>

#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

constexpr double kLongest = 10'000;    // metres; a dive's work by far
constexpr double kFarthest = 100'000;  // metres from the survey's origin
constexpr double kMostLanes = 65'535;

}  // namespace

void PlanConfig::check() const {
  require_setting(length >= 0 && length <= kLongest, "plan.length", "0 to 10000 m");
  require_setting(width >= 0 && width <= kLongest, "plan.width", "0 to 10000 m");
  require_setting((length > 0) == (width > 0), "plan.width",
                  "given with plan.length, or neither of them");
  require_setting(std::abs(bearing_deg) <= 360, "plan.bearing_deg", "-360 to 360");
  require_setting(lane_spacing == 0 || (lane_spacing > 0 && width / lane_spacing <= kMostLanes),
                  "plan.lane_spacing", "0, or above a 65535th of plan.width");
  require_setting(std::abs(corner_x) <= kFarthest, "plan.corner_x", "-100000 to 100000 m");
  require_setting(std::abs(corner_y) <= kFarthest, "plan.corner_y", "-100000 to 100000 m");
  require_setting(std::abs(corner_latitude) <= 90, "plan.corner_latitude", "-90 to 90");
  require_setting(std::abs(corner_longitude) <= 180, "plan.corner_longitude", "-180 to 180");
  require_setting(!is_placed_on_earth() || (corner_x == 0 && corner_y == 0), "plan.corner_x",
                  "0, as plan.corner_y, when plan.corner_latitude and plan.corner_longitude tell");
}

std::optional<coverage::Plan> planned(const PlanConfig& config,
                                      const std::optional<reference::UtmGrid>& grid) {
  if (config.length == 0) return std::nullopt;
  coverage::Plan plan{{config.corner_x, config.corner_y},
                      config.length,
                      config.width,
                      config.bearing_deg * std::numbers::pi / 180,
                      config.lane_spacing};
  if (!config.is_placed_on_earth()) return plan;
  if (!grid) {
    throw InputError(
        "plan.corner_latitude and plan.corner_longitude need reference.origin, which says where "
        "the survey lies; set it, or plan.corner_x and plan.corner_y");
  }
  const auto corner = grid->in_survey({config.corner_latitude, config.corner_longitude, 0});
  if (!corner || !(corner->norm() <= kFarthest)) {
    throw InputError(
        "plan.corner_latitude and plan.corner_longitude are more than 100 km from "
        "reference.origin; correct one of them");
  }
  plan.corner = *corner;
  return plan;
}

void GuideConfig::check() const {
  require_setting(altitude_low >= 0 && altitude_low <= 1000, "guide.altitude_low", "0 to 1000 m");
  require_setting(altitude_high == 0 || (altitude_high > altitude_low && altitude_high <= 1000),
                  "guide.altitude_high", "0, or above guide.altitude_low, to 1000 m");
  require_setting(overlap_low > 0 && overlap_low < 1, "guide.overlap_low", "between 0 and 1");
}

}  // namespace nadir::app
