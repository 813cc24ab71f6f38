// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Footprints of known size and place.
#pragma once

#include "nadir/coverage/footprint.hpp"

namespace nadir::coverage {

/// width to the right of a heading (clockwise from y), length along it, around a place.
inline Footprint footprint_at(std::uint64_t image, double x, double y, double width = 1.6,
                              double length = 1.2, double heading = 0, std::uint32_t submap = 0) {
  const Eigen::Vector3d ahead(std::sin(heading), std::cos(heading), 0),
      right(std::cos(heading), -std::sin(heading), 0), centre(x, y, -4);
  Footprint footprint{image, submap, {}, width, length};
  for (const auto& [aside, along] : {std::pair(-1, 1), {1, 1}, {1, -1}, {-1, -1}})
    footprint.corners.emplace_back(centre + 0.5 * (aside * width * right + along * length * ahead));
  return footprint;
}

}  // namespace nadir::coverage
