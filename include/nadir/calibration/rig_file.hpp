// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The calibration of a camera or a pair, from a survey folder's calib.yml or another program's
// file.
#pragma once

#include <filesystem>

#include "nadir/core/camera_model.hpp"

namespace nadir::calibration {

/// Reads OpenCV FileStorage YAML or XML. Keys: image_width, image_height (px), camera_matrix,
/// distortion_coefficients (4, 5 or 8), distortion_model (brown_conrady, the default, or
/// kannala_brandt with 4 coefficients; other programs' names for the two are understood); for a
/// pair also camera_matrix_right, distortion_coefficients_right, R and T (right_from_left, metres).
/// Other keys are ignored.
///
/// Also reads, told apart by their content: ROS camera_info (file or message), Kalibr's and
/// OpenVINS' camchains, OKVIS, ORB-SLAM, Matisse (YAML), Metashape (XML) and COLMAP's cameras.txt;
/// pixels are converted where their origin differs. Two cameras of one size in a camchain or OKVIS
/// file are a pair, the first of them left; where another choice would be a guess, the file is
/// refused.
///
/// Throws InputError, one line naming file, line, key, fault and remedy, when anything is missing,
/// malformed, of a lens model that CameraModel does not have, or cannot belong to a camera that
/// maps a seabed.
CameraRig load_rig(const std::filesystem::path& file);

}  // namespace nadir::calibration
