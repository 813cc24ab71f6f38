// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The ground that one image shows.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "nadir/core/cloud.hpp"

namespace nadir::coverage {

/// A convex polygon on the image's plane.
struct Footprint {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  std::vector<Eigen::Vector3d> corners;  ///< in turn, survey frame as odometry left it
  double width = 0, length = 0;  ///< along the image's rows and columns, by the scale at its centre
};

/// Of the cells that have a point, whole cells; none when the central one has none.
std::optional<Footprint> footprint_of(const Grid& grid);

}  // namespace nadir::coverage
