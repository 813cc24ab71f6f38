// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "variation.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "nadir/reference/magnetic_model.hpp"

namespace nadir::app {
namespace {

Alert clock_alert(double year) {
  constexpr const char* kByHand =
      "or set sensors.magnetic_variation_deg to what a chart of the place says";
  const std::string now = std::to_string(std::lround(std::floor(year)));
  if (year < reference::kMagneticModelBegin) {
    return {0, std::nullopt, AlertKind::clock,
            "the clock says " + now +
                ": compass headings become true by the magnetic variation of 2025, not of today",
            std::string("set the clock, ") + kByHand};
  }
  return {0, std::nullopt, AlertKind::clock,
          "the clock says " + now +
              ", and the magnetic model ended with 2029: headings may be off by some tenths of a "
              "degree for each year since",
          std::string("update nadir, ") + kByHand};
}

}  // namespace

std::optional<Variation> variation_by_model(const Config& config, Time utc) {
  const auto origin = reference::parse_origin(config.reference.origin);
  if (!origin || config.sensors.inputs.empty() || config.sensors.magnetic_variation_deg != 0)
    return std::nullopt;
  const auto found = reference::magnetic_variation(*origin, utc);
  Variation variation{found.angle * 180 / std::numbers::pi, std::nullopt};
  if (!found.is_within_model()) variation.alert = clock_alert(found.year);
  return variation;
}

}  // namespace nadir::app
