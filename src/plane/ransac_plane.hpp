// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The plane most points agree on: RANSAC (Fischler and Bolles 1981) scored by truncated residuals
// (MSAC, Torr and Zisserman 2000), refined by Tukey-weighted least squares.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "nadir/core/surface.hpp"

namespace nadir::plane {

/// Points within `threshold` (units of the points) of the plane are its inliers. The sign of the
/// normal is arbitrary. None for fewer than three points or when no sample or its inliers span a
/// plane. All points must be finite. Same points, same plane: the generator's seed is fixed.
std::optional<Plane> ransac_plane(const std::vector<Eigen::Vector3d>& points, double threshold,
                                  int max_iterations);

}  // namespace nadir::plane
