// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A planar coloured point cloud: the window's central image projected onto its plane (3DSIP,
// paper 3.4.2).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "nadir/core/surface.hpp"

namespace nadir {

struct CloudPoint {
  Eigen::Vector3d x_in_survey = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> rgb{};
};

/// A regular grid on a plane. The point of cell (column, row) is h.head<3>() / h(3), with
/// h = survey_from_grid * (column, row, 1); it exists where h(3) > 0 and it is within range of the
/// camera.
struct Grid {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  cv::Mat bgr;  ///< CV_8UC3, rows x columns (default 100 x 150)
  Eigen::Matrix<double, 4, 3> survey_from_grid = Eigen::Matrix<double, 4, 3>::Zero();
  Eigen::Vector3d camera_in_survey = Eigen::Vector3d::Zero();
  double max_range = 0;  ///< distance to the camera beyond which a cell has no point

  std::vector<CloudPoint> points() const;
};

/// Exactly one per surface, in order.
struct Cloud {
  std::shared_ptr<const Surface> surface;
  std::optional<Grid> grid;  ///< none when there was no plane
  std::vector<Alert> alerts;
};

}  // namespace nadir
