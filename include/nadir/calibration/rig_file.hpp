// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The calibration of a camera or a pair, from a survey folder's calib.yml.
#pragma once

#include <filesystem>

#include "nadir/core/camera_model.hpp"

namespace nadir::calibration {

/// Reads OpenCV FileStorage YAML or XML. Keys: image_width, image_height (px), camera_matrix,
/// distortion_coefficients (4, 5 or 8), distortion_model (brown_conrady, the default, or
/// kannala_brandt with 4 coefficients; ROS's names for the two are understood); for a pair also
/// camera_matrix_right, distortion_coefficients_right, R and T (right_from_left, metres). Other
/// keys are ignored. Throws InputError naming file, line, key and remedy when anything is missing,
/// malformed or cannot belong to a camera that maps a seabed.
CameraRig load_rig(const std::filesystem::path& file);

}  // namespace nadir::calibration
