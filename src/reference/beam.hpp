// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The two parallel beams in the camera frame.
#pragma once

#include <Eigen/Core>
#include <array>

#include "nadir/calibration/lasers.hpp"

namespace nadir::reference {

/// origin + distance direction; metres, camera frame.
struct Beam {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit

  Eigen::Vector3d at(double distance) const { return origin + distance * direction; }
};

/// Of lasers without fault.
std::array<Beam, 2> beams_of(const calibration::Lasers& lasers);

/// From the first beam to the second, across them.
Eigen::Vector3d across(const std::array<Beam, 2>& beams);

}  // namespace nadir::reference
