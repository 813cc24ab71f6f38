// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// 3D sequential image projection: the window's central image as a planar coloured point cloud
// (3DSIP, paper 3.4.2).
#pragma once

#include <memory>

#include "nadir/core/cloud.hpp"

namespace nadir::projection3d {

struct Config {
  int columns = 150;
  int rows = 100;
  double max_range = 3;  ///< longest ray, as a ratio of the camera's distance to the plane

  /// Throws InputError naming the setting, its range and the remedy.
  void check() const;
};

/// Projects central images onto their planes. The grid covers the largest rectangle of the
/// undistorted image that is centred on the image centre ((w - 1) / 2, (h - 1) / 2) and lies
/// inside the real image; a cell's colour is the mean of the pixels it covers and its point the
/// intersection of its central ray with the plane. What depends on the lens alone is kept from
/// call to call.
class PlaneProjection {
 public:
  explicit PlaneProjection(const Config& config);
  ~PlaneProjection();
  /// One cloud per surface, in order. No grid without a plane, when the camera lies on or behind
  /// the plane, when the image centre's ray misses it within range, or when the lens model has no
  /// inverse over the image.
  Cloud process(std::shared_ptr<const Surface> surface);

 private:
  struct Lens;
  const Lens& lens_of(const std::shared_ptr<const CameraRig>& rig);

  Config config_;
  std::unique_ptr<const Lens> lens_;  ///< of the last rig seen
};

}  // namespace nadir::projection3d
