// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "undistorted_grid.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nadir::projection3d {
namespace {

using Eigen::Vector2d;

// Half the sides of the rectangle: the border's nearest approach in x on the left and right, in y
// on top and bottom. The border bulges outwards between the corners or inwards, never both ways.
std::optional<Vector2d> half_sides(const CameraModel& camera, const Vector2d& centre) {
  const double right = camera.width - 1, bottom = camera.height - 1;
  Vector2d half = Vector2d::Constant(std::numeric_limits<double>::infinity());
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = right * i / kSteps, v = bottom * i / kSteps;
    const Vector2d border[] = {{0, v}, {right, v}, {u, 0}, {u, bottom}};
    for (int side = 0; side < 4; ++side) {
      const std::optional<Vector2d> ray = camera.unproject(border[side]);
      if (!ray) return std::nullopt;
      const int axis = side / 2;
      half(axis) = std::min(half(axis), std::abs((*ray - centre)(axis)));
    }
  }
  return half;
}

int pixels_per_cell(const CameraModel& camera, int columns, int rows) {
  const int across = (camera.width + columns - 1) / columns;
  const int down = (camera.height + rows - 1) / rows;
  return std::max({1, across, down});
}

}  // namespace

std::optional<UndistortedGrid> undistorted_grid(const CameraModel& camera, int columns, int rows) {
  const auto centre = camera.unproject({(camera.width - 1) / 2.0, (camera.height - 1) / 2.0});
  const auto half = centre ? half_sides(camera, *centre) : std::nullopt;
  if (!half) return std::nullopt;

  UndistortedGrid grid;
  const double x = 2 * half->x() / columns, y = 2 * half->y() / rows;  // cell sides
  grid.camera_from_grid << x, 0, centre->x() - x * (columns - 1) / 2,  //
      0, y, centre->y() - y * (rows - 1) / 2, 0, 0, 1;
  constexpr int kFine = 3;  // bounds the map: 0.6 million samples for 150 x 100 cells at worst
  grid.divisor = std::max(1, pixels_per_cell(camera, columns, rows) / kFine);
  const CameraModel reduced = camera.reduced(grid.divisor);
  grid.fineness = pixels_per_cell(reduced, columns, rows);

  cv::Mat map(rows * grid.fineness, columns * grid.fineness, CV_32FC2);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.cols; ++column) {
      const Eigen::Vector3d cell((column + 0.5) / grid.fineness - 0.5,
                                 (row + 0.5) / grid.fineness - 0.5, 1);
      const auto pixel = reduced.project(grid.camera_from_grid * cell);
      if (!pixel) return std::nullopt;
      map.at<cv::Vec2f>(row, column) = {static_cast<float>(pixel->x()),
                                        static_cast<float>(pixel->y())};
    }
  }
  cv::convertMaps(map, cv::noArray(), grid.pixels, grid.fractions, CV_16SC2);
  return grid;
}

}  // namespace nadir::projection3d
