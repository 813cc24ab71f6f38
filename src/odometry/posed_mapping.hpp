// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Tie points of images whose poses are given and held.
#pragma once

#include "map.hpp"
#include "resection.hpp"

namespace nadir::odometry {

/// The map's tie points found in an image at this pose.
Resection measure_at(const Map& map, const View& view, const Rigid3& camera_from_map,
                     const Config& config);

struct Connection {
  int agreeing = 0;  ///< correspondences whose rays meet
  int inserted = 0;  ///< tie points made of them
};

/// Tie points of an earlier key frame and the last one from their correspondences: where neither
/// has any, nothing tells yet how deep to look for more.
Connection connect(Map& map, int host, const Correspondences& matched, const Config& config);

/// RMS reprojection error of a key frame's tie points in it, px.
double rms_px(const Map& map, const KeyFrame& key_frame);

/// Metres per unit of the map.
struct PairScale {
  double metres = 1;
  double sigma = 0;  ///< relative, 1 sigma
};

/// From the tie points of the last key frames and the right images of their pairs; none with too
/// few of them.
std::optional<PairScale> pair_scale(const Map& map, int key_frames);

}  // namespace nadir::odometry
