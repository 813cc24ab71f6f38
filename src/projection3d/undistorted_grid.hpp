// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A regular grid of rays inside a distorted image, and the pixels each ray passes.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "nadir/core/camera_model.hpp"

namespace nadir::projection3d {

struct UndistortedGrid {
  Eigen::Matrix3d camera_from_grid;  ///< ray (x, y, 1) through the centre of cell (column, row, 1)
  int divisor = 1;                   ///< the image is reduced by, pixel areas averaged, before
  int fineness = 1;                  ///< samples per cell and side, about one per reduced pixel
  cv::Mat pixels, fractions;         ///< CV_16SC2 and CV_16UC1 map of all samples in the reduced
                                     ///< image, for cv::remap
};

/// The largest grid centred on the image centre whose cells all lie inside the image; none when
/// the lens model has no inverse at the centre or the border.
std::optional<UndistortedGrid> undistorted_grid(const CameraModel& camera, int columns, int rows);

}  // namespace nadir::projection3d
