// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What attitude and depth sensors say along a path, from 0 to `end` seconds.
#pragma once

#include <vector>

#include "nadir/simulate/survey.hpp"
#include "path.hpp"

namespace nadir::simulate {

std::vector<AttitudeReading> attitude_readings(const Path& path, double end, std::uint64_t seed);
/// surface: height of the water's surface in local.
std::vector<DepthReading> depth_readings(const Path& path, double surface, double end,
                                         std::uint64_t seed);

}  // namespace nadir::simulate
