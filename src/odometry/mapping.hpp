// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A new key frame and what follows from it: new tie points, the window adjustment (paper 3.2,
// step ii), the window that is published.
#pragma once

#include "map.hpp"
#include "resection.hpp"
#include "window_adjustment.hpp"

namespace nadir::odometry {

/// Appends the key frame with its sightings; in a pair each is looked up in the right image too.
void add_key_frame(Map& map, std::shared_ptr<const View> view, const Resection& resection);

/// New tie points: in a pair from left and right image of the last key frame, else from earlier key
/// frames of the window and the last one.
void add_tie_points(Map& map, const Config& config);

/// A tie point hosted by a key frame whose view is alive: patch, colour, descriptor; no place yet.
MapPoint new_point(const Map& map, int host, int feature, const Eigen::Vector2d& pixel,
                   const Patch& patch, const Eigen::Vector3d& normal_in_host);
void insert(Map& map, MapPoint point);

/// Adjusts the last `window` key frames and their tie points; all earlier ones, and at least the
/// first `fixed`, are held. Takes out what does not fit.
AdjustmentSummary adjust_window(Map& map, int window, int fixed);

/// Lets the images of key frames that left the window die, later their descriptors.
void retire(Map& map, const Config& config);

Window make_window(const Map& map, int window, const AdjustmentSummary& summary);
ImagePose pose_of(const Map& map, const KeyFrame& key_frame);

}  // namespace nadir::odometry
