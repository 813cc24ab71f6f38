// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A key frame in the map of all key frames.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "nadir/core/key_frame.hpp"
#include "nadir/odometry/depth_prior.hpp"

namespace nadir::revisit {

struct Node {
  explicit Node(const SettledKeyFrame& key_frame);

  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  std::shared_ptr<const CameraRig> rig;
  Rigid3 live;                        ///< survey_from_camera as odometry left it
  Similarity3 corrected_from_camera;  ///< lengths in the camera frame are odometry's
  bool metric = false;                ///< of a stereo pair: its lengths are right
  bool upright = false;               ///< its vertical is measured, not guessed from the ground
  Features features;                  ///< corners
  std::vector<std::uint8_t> picture;  ///< grey JPEG, reduced
  std::optional<Features> blobs;      ///< of the picture, once they were wanted
  std::vector<TiePointObservation> observations;
  odometry::DepthPrior prior;  ///< of the ground, odometry's lengths
  double depth = 0;            ///< median of its tie points along the optical axis

  Similarity3 corrected_from_live() const {
    return corrected_from_camera * Similarity3{1, live.inverse()};
  }
  /// Finds the blobs when they are not known yet; none of a picture that cannot be read.
  const Features& find_blobs();

  /// Where the optical axis meets the ground.
  Eigen::Vector3d ground_centre() const {
    return corrected_from_camera * Eigen::Vector3d(0, 0, depth);
  }
  /// Mean side of the ground in the image.
  double footprint() const {
    const CameraModel& camera = rig->left;
    return corrected_from_camera.scale * depth * 0.5 *
           (camera.width / camera.fx + camera.height / camera.fy);
  }
};

}  // namespace nadir::revisit
