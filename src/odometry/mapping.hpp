// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A new key frame and its new tie points.
#pragma once

#include "map.hpp"
#include "resection.hpp"

namespace nadir::odometry {

/// Tie points looked for in the right image of a key frame, and found where its pose puts them.
struct InRight {
  int looked_for = 0, found = 0;
};

/// Appends the key frame with its sightings; in a pair each is looked up in the right image too.
/// One that shows something else (frozen, of another moment, knocked) is left out.
InRight add_key_frame(Map& map, std::shared_ptr<const View> view, const Resection& resection);

/// Enough was looked for, and too little found.
bool is_foreign(const InRight& right);

/// New tie points: in a pair from left and right image of the last key frame, else from earlier key
/// frames of the window and the last one.
void add_tie_points(Map& map, const Config& config);

/// A tie point hosted by a key frame whose view is alive: patch, colour, descriptor; no place yet.
MapPoint new_point(const Map& map, int host, int feature, const Eigen::Vector2d& pixel,
                   const Patch& patch, const Eigen::Vector3d& normal_in_host);
void insert(Map& map, MapPoint point);

}  // namespace nadir::odometry
