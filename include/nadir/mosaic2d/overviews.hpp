// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The mosaics from afar, for who looks at all of a dive at once.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "nadir/core/tile.hpp"

namespace nadir::mosaic2d {

/// Overview (column, row) of a mosaic shows tiles [8 column, 8 column + 7] x [8 row, ...] in as
/// many pixels as one of them has. Memory: 4 kB a tile where tiles are many.
class Overviews {
 public:
  static constexpr int kTiles = 8;  ///< per side

  /// Shows the tile in place of an earlier one of its place.
  void add(const Tile& tile);

  /// Those that have changed since they were taken, at most so many in turn, as tiles whose column
  /// and row count overviews. A pixel is the mean of what was seen in 8 x 8 of a tile's, its alpha
  /// how much of them that was.
  std::vector<Tile> take(std::size_t most);

 private:
  using Place = std::tuple<std::uint32_t, std::int32_t, std::int32_t>;  ///< mosaic, row, column
  std::map<Place, cv::Mat> overviews_;
  std::set<Place> changed_;
  Place last_{0, INT32_MIN, INT32_MIN};  ///< taken
};

}  // namespace nadir::mosaic2d
