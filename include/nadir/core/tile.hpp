// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The 2D mosaic (2DSIM, paper 3.4.1): projected images, their world files, and the running mosaic's
// tiles.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "nadir/core/surface.hpp"

namespace nadir {

/// The six values of an ESRI world file: x = a column + b row + c, y = d column + e row + f,
/// where (0, 0) is the centre of the upper-left pixel. The file's order is a d b e c f.
struct WorldFile {
  double a = 1, d = 0, b = 0, e = -1, c = 0, f = 0;

  Eigen::Vector2d operator()(double column, double row) const {
    return {a * column + b * row + c, d * column + e * row + f};
  }
};

/// One image warped onto its plane, north up.
struct ProjectedImage {
  std::uint64_t image = 0;
  cv::Mat bgra;  ///< CV_8UC4, alpha 0 outside the image
  WorldFile world;
};

/// One mosaic's raster grid. Tile (column, row) covers pixels [256 column, 256 column + 255] x [256
/// row, ...] of an unbounded north-up raster whose pixel (0, 0) has its centre at world(0, 0); rows
/// grow southwards, both may be negative.
struct MosaicGrid {
  static constexpr int kTileSize = 256;  ///< px per side
  std::uint32_t mosaic = 0;              ///< number in the dive, from 0
  std::uint32_t submap = 0;
  double ground_sampling_distance = 0;  ///< metres (or survey units) per px
  WorldFile world;                      ///< of pixel (0, 0) of tile (0, 0)
  Plane plane;                          ///< that began the mosaic
};

struct Tile {
  std::uint32_t mosaic = 0;
  std::int32_t column = 0, row = 0;
  cv::Mat bgra;  ///< CV_8UC4 256 x 256, alpha 0 where nothing was seen
};

/// Exactly one per surface, in order.
struct MosaicUpdate {
  std::shared_ptr<const Surface> surface;
  std::optional<MosaicGrid> grid;  ///< the mosaic the image went to; none when there was no plane
  std::optional<ProjectedImage> projected;
  std::vector<std::shared_ptr<const Tile>> tiles;  ///< new or changed
  std::vector<Alert> alerts;
};

}  // namespace nadir
