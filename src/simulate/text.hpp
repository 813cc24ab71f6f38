// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The text files of a survey folder. Every function returns a whole file.
#pragma once

#include <string>

#include "nadir/simulate/survey.hpp"

namespace nadir::simulate {

std::string calibration(const CameraRig& rig);                    ///< calib.yml
std::string lasers(const Lasers& lasers);                         ///< lasers.yml
std::string timestamps(const Survey& survey);                     ///< timestamps.csv
std::string attitudes(const Survey& survey);                      ///< ahrs.csv
std::string depths(const Survey& survey);                         ///< depth.csv
std::string poses(const Survey& survey, const Options& options);  ///< gt_poses_tum.txt
std::string points(const Survey& survey);                         ///< gt_points.csv
std::string observations(const Survey& survey);                   ///< gt_observations.csv
std::string dots(const Survey& survey);                           ///< gt_laser_dots.csv
std::string readme(const Survey& survey, const Options& options);

}  // namespace nadir::simulate
