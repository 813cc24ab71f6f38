// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/cloud.hpp"

namespace nadir {

std::vector<CloudPoint> Grid::points() const {
  std::vector<CloudPoint> points;
  points.reserve(static_cast<std::size_t>(bgr.total()));
  for (int row = 0; row < bgr.rows; ++row) {
    for (int column = 0; column < bgr.cols; ++column) {
      const Eigen::Vector4d h = survey_from_grid * Eigen::Vector3d(column, row, 1.0);
      if (!(h(3) > 0)) continue;
      const Eigen::Vector3d x = h.head<3>() / h(3);
      if (!((x - camera_in_survey).norm() <= max_range)) continue;
      const cv::Vec3b& pixel = bgr.at<cv::Vec3b>(row, column);
      points.push_back({x, {pixel[2], pixel[1], pixel[0]}});
    }
  }
  return points;
}

}  // namespace nadir
