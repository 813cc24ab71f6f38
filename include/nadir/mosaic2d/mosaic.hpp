// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One running mosaic: projected images blended into tiles as they come (2DSIM, paper 3.4.1).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "nadir/core/tile.hpp"

namespace nadir::mosaic2d {

struct Patch;

/// Memory follows the area seen: tiles exist where an image fell. Tiles given out are never
/// written again; a changed tile is a new one. 65536 images change a tile at most.
///
/// A ground pixel shows the image whose centre is nearest to it, so seams are straight lines half
/// way between image centres, feathered by a few pixels there and along image borders. Centre and
/// borders of an image are taken from its alpha channel alone and every step depends on nothing but
/// the grid and the projected images added before: the same projected images, read back from their
/// files and added in the same order, give the same tiles bit by bit.
class Mosaic {
 public:
  explicit Mosaic(const MosaicGrid& grid) : grid_(grid) {}

  const MosaicGrid& grid() const { return grid_; }
  /// All tiles, row by row from north to south.
  std::vector<std::shared_ptr<const Tile>> tiles() const;

  /// Blends an image in; returns the tiles that changed, row by row. The image must be CV_8UC4 and
  /// north up on the grid's raster: its world file within 1/100 px of a pixel, the same sampling
  /// distance. Its alpha is 0, which is ignored, or 255.
  std::vector<std::shared_ptr<const Tile>> add(const ProjectedImage& image);

  /// The factor per channel (B, G, R) that brings an image to the mean of what the mosaic already
  /// shows where both are; 1 where there is too little of that.
  cv::Vec3d gain_to_match(const ProjectedImage& image) const;

 private:
  struct Cell {
    std::shared_ptr<const Tile> tile;
    cv::Mat owner;   ///< CV_16UC1: index in `centres` of the image a pixel shows most of
    cv::Mat border;  ///< CV_8UC1: distance to the nearest border of what was seen, px, saturated
    std::vector<cv::Point2d> centres;  ///< of the images blended in, px of the raster
  };
  using Index = std::pair<std::int32_t, std::int32_t>;  ///< row, column

  cv::Point origin_of(const ProjectedImage& image) const;
  bool blend(const Patch& image, cv::Point origin, cv::Point2d centre, Index index,
             Cell& cell) const;

  MosaicGrid grid_;
  std::map<Index, Cell> cells_;
};

}  // namespace nadir::mosaic2d
