// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/cloud.hpp"

#include <gtest/gtest.h>

namespace nadir {
namespace {

TEST(Grid, LeavesOutCellsBehindTheCameraAndOutOfRange) {
  Grid grid;
  grid.bgr = cv::Mat(1, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  grid.survey_from_grid.row(0) << 1, 0, 0;   // x = column / w
  grid.survey_from_grid.row(3) << -1, 0, 2;  // w = 2 - column: 2, 1, 0, -1
  grid.max_range = 0.5;
  const auto points = grid.points();
  ASSERT_EQ(points.size(), 1u);  // column 1 lies at x = 1, out of range
  EXPECT_EQ(points[0].x_in_survey, Eigen::Vector3d::Zero());
  EXPECT_EQ(points[0].rgb, (std::array<std::uint8_t, 3>{3, 2, 1}));
}

}  // namespace
}  // namespace nadir
