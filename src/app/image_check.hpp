// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether the cameras' images are fit for a map, and what the sensors add to them.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "config.hpp"
#include "nadir/core/finding.hpp"
#include "nadir/core/window.hpp"
#include "nadir/odometry/pair_fit.hpp"

namespace nadir::app {

/// wanted_hz 0: any.
Finding check_rate(double rate_hz, double wanted_hz);

/// Of a camera that has given no image for so long.
Finding check_silence(std::chrono::seconds silence);

/// Exposure and focus.
std::vector<Finding> check_picture(const Health& health);

/// How far an edge is smeared, by the picture's sharpness: 1 px where it is called blurred
/// (weak_sharpness), half as much at four times the sharpness; at most 10 px.
double blur_px(const Health& health, double weak_sharpness);

/// By the motion of the ground in the image, px a second, during the exposure.
double motion_blur_px(double speed_px, double exposure_ms);

/// Between the stamps of a pair.
Finding check_skew(std::optional<Time> skew, double most_ms);

/// Whether a pair's images fit their calibration.
Finding check_pair(const odometry::PairFit& fit);

/// Which of the sensors' quantities an image has, its heading from true north. inputs:
/// sensors.inputs; convergence: of the grid from whose north the frame's yaw is, radians.
Finding check_vehicle(const Frame& frame, const std::string& inputs, double convergence = 0);

}  // namespace nadir::app
