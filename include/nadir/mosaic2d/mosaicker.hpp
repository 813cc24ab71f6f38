// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// 2D sequential image mosaicing: the window's central image, undistorted and warped north-up onto
// its plane in one resampling, blended into the running mosaic (2DSIM, paper 3.4.1).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "nadir/core/tile.hpp"
#include "nadir/mosaic2d/mosaic.hpp"

namespace nadir::mosaic2d {

struct Config {
  double ground_sampling_distance = 0;  ///< survey units per px; 0: that of a mosaic's first image
  double max_megapixels = 8;            ///< of one projected image; coarser sampling keeps to it
  double max_range = 3;       ///< longest ray, as a ratio of the camera's distance to the plane
  double max_slope_deg = 65;  ///< of a plane against survey XY; steeper ground is not mosaicked
  bool even_light = true;     ///< flatten the lamps' pattern and the exposure's steps

  // A new mosaic starts when the plane departs from the one that began the mosaic (restart rule):
  double restart_angle_deg = 25;  ///< between the normals
  double restart_offset = 0.3;  ///< along survey z below the image centre, of the viewing distance
  double restart_rms = 2;       ///< growth of the RMS, itself at least 1 % of the viewing distance
  double restart_zoom = 2;      ///< coarser or finer than the mosaic's sampling by this factor
  int restart_after = 2;        ///< so many departing images in a row; a single one is forgiven

  /// Throws InputError naming the setting, its range and the remedy.
  void check() const;
};

/// Survey XY is the raster: x east, y north, rows southwards; the plane's points are projected
/// along survey z.
class Mosaicker {
 public:
  explicit Mosaicker(const Config& config);
  ~Mosaicker();
  /// One update per surface, in order. Nothing but the source and alerts where there is no plane,
  /// the plane is too steep for a north-up raster, or the image centre does not meet it in range.
  MosaicUpdate process(std::shared_ptr<const Surface> surface);

  /// Pixels this many times as large from the next image on, in a new mosaic; 1 as configured.
  void coarsen(double factor);

  /// No more surfaces come: lets the mosaic's memory go.
  void finish();

 private:
  struct State;
  Config config_;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::mosaic2d
