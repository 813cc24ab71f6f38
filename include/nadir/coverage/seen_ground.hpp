// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which ground the images have shown, as outlines: small enough to be sent to an autopilot.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace nadir::coverage {

/// A raster of the ground, coarser as it grows: the first footprint is some 32 cells wide, and the
/// memory stays below 16 MB, whatever is asked of it.
class SeenGround {
 public:
  /// Corners of a convex footprint in turn, survey x and y.
  void add(std::span<const Eigen::Vector2d> footprint);

  /// Makes cells twice as wide, seen where any part of them was: for a shorter outline.
  void coarsen();

  /// Polygons in turn, those around holes too, within one cell; survey x and y.
  std::vector<std::vector<Eigen::Vector2d>> outline() const;
  double area() const;  ///< survey units squared
  double cell() const { return cell_; }

 private:
  void make_room(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  Eigen::Vector2d in_cells(const Eigen::Vector2d& ground) const;

  double cell_ = 0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  ///< of the first cell's corner
  cv::Mat seen_;                                      ///< CV_8UC1, 255 where seen; row along y
};

}  // namespace nadir::coverage
