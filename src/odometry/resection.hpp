// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Orientation of a new image relative to the map: first roughly by descriptors, then by every tie
// point that should be visible, found with sub-pixel precision.
#pragma once

#include <span>

#include "loss.hpp"
#include "map.hpp"
#include "nadir/odometry/correspondence.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "pose_covariance.hpp"

namespace nadir::odometry {

struct Seen {
  int point = 0;
  Eigen::Vector2d pixel, ray;
};

struct Resection {
  Rigid3 camera_from_map;
  std::vector<Seen> seen;
  int expected = 0;  ///< tie points that should have been visible
  double rms_px = 0;
};

struct ResectionResult {
  std::optional<Resection> resection;
  LossReason reason{};  ///< why there is none
};

/// `predicted`: where the camera may be, if anything is known. `references`: key frames whose
/// descriptors are tried, most likely first.
/// Effort::thorough: by blobs when corners fail, which takes as long as some images.
enum class Effort { quick, thorough };
ResectionResult resect(const Map& map, const View& view, std::optional<Rigid3> predicted,
                       std::span<const int> references, const Config& config,
                       Effort effort = Effort::quick);

/// Of the pose against the tie points, which are taken as exact. Zero when unknown.
Sigmas sigmas_of(const Map& map, const Resection& resection);

/// An image in which nothing can be measured.
bool is_blank(const View& view);

/// Why an image that matches nothing did not: silt and open water have corners too, but of noise.
LossReason reason_without_matches(const View& view);

}  // namespace nadir::odometry
