// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The earth's magnetic field by the World Magnetic Model 2025 (NOAA/NCEI and BGS), for headings
// from true north.
#pragma once

#include <Eigen/Core>

#include "nadir/core/time.hpp"
#include "nadir/reference/geodetic.hpp"

namespace nadir::reference {

/// Years of the model: from the beginning of the first to that of the last.
inline constexpr double kMagneticModelBegin = 2025, kMagneticModelEnd = 2030;

/// East, north and up, nanotesla. year: 2026.5 is the middle of 2026.
Eigen::Vector3d magnetic_field(const Geodetic& place, double year);

struct MagneticVariation {
  double angle = 0;  ///< true minus magnetic north, east positive, radians
  double year = 0;   ///< as asked for; the angle is that of the model's nearest
  bool is_within_model() const { return year >= kMagneticModelBegin && year <= kMagneticModelEnd; }
};

/// utc: since the UNIX epoch.
MagneticVariation magnetic_variation(const Geodetic& place, Time utc);

}  // namespace nadir::reference
