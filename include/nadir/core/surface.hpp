// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A window with its fitted plane, or the reason why there is none (paper 3.3).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nadir/core/window.hpp"

namespace nadir {

/// Points x of the plane satisfy normal . x = offset; survey frame.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, towards the cameras
  double offset = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of the inliers
  std::uint32_t inliers = 0;
  double inlier_ratio = 0;
  double rms = 0;  ///< of the inliers' distances
  int iterations = 0;

  double distance(const Eigen::Vector3d& x) const { return normal.dot(x) - offset; }
};

/// Exactly one per orientation, in order; without a window there is nothing but the source.
struct Surface {
  std::shared_ptr<const Orientation> orientation;
  std::optional<Plane> plane;
  std::string why_not;  ///< one line when a window has no plane
  std::vector<Alert> alerts;

  const Window* window() const { return orientation->window.get(); }
};

}  // namespace nadir
