// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Laser pointers mounted beside the camera at a known separation.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

namespace nadir::calibration {

enum class LaserColour { red, green, blue };

struct Lasers {
  double separation = 0;  ///< metres, across the beams
  LaserColour colour = LaserColour::green;
  bool parallel_to_optical_axis = false;
  std::vector<Eigen::Vector3d> origins_in_camera;      ///< metres; empty when not given
  std::optional<Eigen::Vector3d> direction_in_camera;  ///< unit
};

/// Reads lasers.yml: separation_m, and optionally colour, parallel_to_optical_axis,
/// origins_camera_m (n x 3) and direction_camera. Throws InputError as load_rig does.
Lasers load_lasers(const std::filesystem::path& file);

}  // namespace nadir::calibration
