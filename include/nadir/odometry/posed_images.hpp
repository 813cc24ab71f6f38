// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// In place of visual odometry: images whose poses another program found. Tie points are measured
// with the poses held fixed; what comes out is what odometry would say.
#pragma once

#include "nadir/core/given_poses.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {

/// Images of one map, sub-map 0. Those without a given pose are lost, with an alert. Where images
/// share no ground with the ones before, tie points do not connect and a new window begins.
///
/// Frame: poses of the survey frame go out as they were given. Others are moved once, to where
/// `placement` puts the first window, and wait for it.
/// Scale: metric poses keep theirs (ScaleSource::poses); a pair's baseline only checks it, and
/// scale_conflict says when it is another. Others take the baseline of a pair, else have none.
class PosedImages {
 public:
  /// Of the configuration, what initialises and relocalises has no effect.
  PosedImages(Config config, GivenPoses poses, Placement placement);
  PosedImages(PosedImages&&) noexcept;
  PosedImages& operator=(PosedImages&&) noexcept;
  ~PosedImages();

  /// As VisualOdometry::process.
  Orientation process(std::shared_ptr<const Shot> shot);

  /// After the last shot: images that waited for a first window in vain are lost.
  Orientation finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::odometry
