// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What of the ground that is to be covered was seen, and where the gaps are.
//
// To be covered is a given polygon; else the ground swept so far: what was seen, what lies between
// it where that is at most 1.5 footprints wide, and holes of any size. Counts are kept by cell.
// What is to be covered is worked out on blocks of 1, 2, 4 ... 64 cells a side, as few as give at
// most half a million blocks, so that its cost is bounded; ground beyond the largest raster, some
// 700 tiles a side around the newest footprint, is counted and has no gaps.
#pragma once

#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "nadir/coverage/counts.hpp"

namespace nadir::coverage {

struct Gap {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< inside it, within a cell
  double area = 0;
};

/// x and y of the survey frame throughout. Used by one thread.
class Coverage {
 public:
  using Pixels = Counts::Cells;

  /// cell: as of Counts.
  explicit Coverage(double cell = 0);
  ~Coverage();

  void add(const Footprint& footprint);
  void correct(const std::vector<Correction>& corrections);
  /// What is to be covered from now on, convex; none: the ground swept.
  void aim(std::optional<Polygon> ground);

  /// Takes in all that was told; what follows is as of then. The tiles that look different now.
  std::vector<Place> update();

  double cell() const { return counts_.cell(); }
  /// Of the first footprint, as corrected; 0 before it.
  double footprint_width() const;
  const Corrections& corrections() const { return counts_.corrections(); }

  /// Of each cell: images that show it, at most 127; 128 more where it is to be covered.
  Pixels pixels(const Place& place) const;
  double area() const;     ///< to be covered
  double covered() const;  ///< of that, seen
  double seen() const;     ///< to be covered or not
  /// Share of what is to be covered in a convex part of it, within a block; 0 of none.
  double covered(const Polygon& part) const;
  /// Regions into which a circle of two cells' radius fits, within a block, of at least 16 cells;
  /// those nearest to a place, by their centres, first.
  std::vector<Gap> gaps(const Eigen::Vector2d& from, std::size_t most) const;

 private:
  struct Blocks;

  Polygon in_cells(const Polygon& polygon) const;
  double radius_in_cells() const;
  cv::Rect extent() const;
  bool must_be_framed_anew() const;
  void frame_anew(std::set<Place>& changed);
  void take_in(const Place& place);
  void work_out(std::set<Place>& changed);
  void find_gaps();

  Counts counts_;
  std::optional<Footprint> first_;  ///< without its corners
  std::optional<Polygon> aim_;
  bool aimed_anew_ = false;
  std::optional<Place> newest_;  ///< tile of the last footprint
  std::unique_ptr<Blocks> blocks_;
  std::vector<Gap> gaps_;
};

}  // namespace nadir::coverage
