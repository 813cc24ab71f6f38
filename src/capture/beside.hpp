// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What lies beside the images or the video of a survey.
#pragma once

#include <filesystem>
#include <optional>

#include "nadir/calibration/lasers.hpp"
#include "nadir/core/camera_model.hpp"

namespace nadir::capture {

/// Images are never exactly as far apart as their rate says: so much of its period is enough.
inline constexpr double kRateSlack = 0.95;

/// The calibration given, or FOLDER/calib.yml.
std::filesystem::path calibration_file(const std::filesystem::path& folder,
                                       const std::optional<std::filesystem::path>& calibration);

/// Its cameras. Throws InputError when it is not there or malformed.
CameraRig load_calibration(const std::filesystem::path& file);

/// FOLDER/lasers.yml, if it is there. Throws InputError when malformed.
std::optional<calibration::Lasers> lasers_beside(const std::filesystem::path& folder);

}  // namespace nadir::capture
