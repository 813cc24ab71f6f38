// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The cells of a raster whose centre lies in a convex polygon, row by row.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core/types.hpp>

#include "nadir/coverage/polygon.hpp"

namespace nadir::coverage {

inline int as_cell(double value) {
  constexpr double kFarthest = 1 << 28;
  return static_cast<int>(std::clamp(value, -kFarthest, kFarthest));
}

/// The rectangle of whole cells around a polygon.
inline cv::Rect bounds(const Polygon& in_cells) {
  Eigen::Vector2d low = in_cells.front(), high = low;
  for (const Eigen::Vector2d& corner : in_cells) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const auto floored = [](double value) { return as_cell(std::floor(value)); };
  return {cv::Point(floored(low.x()), floored(low.y())),
          cv::Point(floored(high.x()) + 1, floored(high.y()) + 1)};
}

/// take(row, first, end) for each row within the rectangle that has such cells. A cell whose centre
/// lies on the border of two polygons is in one of them.
template <class Take>
void for_spans(const Polygon& in_cells, const cv::Rect& within, Take take) {
  const cv::Rect rows = bounds(in_cells) & within;
  for (int row = rows.y; row < rows.y + rows.height; ++row) {
    const double y = row + 0.5;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < in_cells.size(); ++i) {
      const Eigen::Vector2d &a = in_cells[i], &b = in_cells[(i + 1) % in_cells.size()];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (!(low < high)) continue;
    const int first = std::max(within.x, as_cell(std::ceil(low - 0.5)));
    const int end = std::min(within.x + within.width, as_cell(std::ceil(high - 0.5)));
    if (first < end) take(row, first, end);
  }
}

}  // namespace nadir::coverage
