// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Convex polygons in the plane.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nadir::coverage {

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in turn, either way round

/// Never negative.
double area(const Polygon& polygon);

/// What two convex polygons have in common; empty when nothing.
Polygon clipped(const Polygon& polygon, const Polygon& by);

}  // namespace nadir::coverage
