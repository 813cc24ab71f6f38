// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How far the ground is along a ray of an image, by the tie points around it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "nadir/core/window.hpp"

namespace nadir::reference {

/// A tie point as an image sees it.
struct Seen {
  Eigen::Vector2d ray;       ///< x/z, y/z
  double inverse_depth = 0;  ///< per map unit
};

/// Those in front of the camera.
std::vector<Seen> seen_by(const ImagePose& pose, const std::vector<TiePoint>& tie_points);

/// Inverse depth of the surface along a ray, in map units: of a plane through the nearest tie
/// points, of which the nearer ones and those that agree count more. None where they do not
/// surround it.
std::optional<double> surface_at(const Eigen::Vector2d& ray, const std::vector<Seen>& seen);

/// Of at least one value.
double median(std::vector<double> values);

/// Tukey's weight: 1 for what agrees, 0 beyond 4.7 sigma.
double agreement_of(double residual, double sigma);

}  // namespace nadir::reference
