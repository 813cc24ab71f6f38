// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Rasters moved by a correction of poses.
#pragma once

#include "nadir/core/rigid3.hpp"
#include "nadir/core/tile.hpp"

namespace nadir::mosaic2d {

/// Where a raster's pixels, which lie on a plane that is not vertical, are after a correction.
WorldFile moved(const WorldFile& world, const Plane& plane, const Similarity3& correction);
/// The raster and the plane that began it.
MosaicGrid moved(MosaicGrid grid, const Similarity3& correction);

/// North up again, about its pixel (0, 0), at the mean sampling distance.
MosaicGrid levelled(MosaicGrid grid);

/// Resampled onto the grid's raster, north up; alpha 0 where the image does not reach. Without
/// pixels where that would take many times the image's, or lies beyond 2^29 px of the raster.
ProjectedImage aligned(const ProjectedImage& image, const MosaicGrid& grid);

}  // namespace nadir::mosaic2d
