// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The last key frames of a map: their adjustment (paper 3.2, step ii), and the window that is
// published.
#pragma once

#include "map.hpp"
#include "nadir/odometry/bundle_adjustment.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {

/// Adjusts the last `window` key frames and their tie points; all earlier ones, and at least the
/// first `fixed`, are held. Takes out what does not fit.
AdjustmentSummary adjust_window(Map& map, int window, int fixed, const Config& config);

using Settled = std::vector<std::shared_ptr<const SettledKeyFrame>>;

/// Lets the images of key frames that left the window die, and hands out those that are too old to
/// find recent ground by: their descriptors go with them.
Settled retire(Map& map, const Config& config);
/// Of a map that ends.
Settled retire_all(Map& map);

Window make_window(const Map& map, int window, const AdjustmentSummary& summary);
ImagePose pose_of(const Map& map, const KeyFrame& key_frame);

}  // namespace nadir::odometry
