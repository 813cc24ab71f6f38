// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The relative pose and scale of two key frames that show the same ground.
#pragma once

#include <optional>
#include <vector>

#include "node.hpp"

namespace nadir::revisit {

/// A tie point of the first node found in the second.
struct CrossSighting {
  int observation = 0;  ///< of the first node
  Eigen::Vector2d ray;  ///< normalised coordinates in the second
};

/// A corner of both that is no tie point.
struct CommonCorner {
  Eigen::Vector2d first, second;  ///< normalised coordinates
  Eigen::Vector3d x_in_first;     ///< camera frame, the first's lengths; its depth is a guess
};

struct Link {
  int first = 0, second = 0;      ///< nodes
  Similarity3 second_from_first;  ///< camera frames, each in its own odometry's lengths
  int inliers = 0;                ///< corners that agree
  std::vector<CrossSighting> sightings;
  std::vector<CommonCorner> corners;
};

/// None when the two do not fit, or so few or so crowded corners say so that it may be chance.
std::optional<Link> link(const std::vector<Node>& nodes, int first, int second);

/// The same by blobs, which are found when they are not known yet: slow, for dim and uneven ground.
std::optional<Link> link_by_blobs(std::vector<Node>& nodes, int first, int second);

}  // namespace nadir::revisit
