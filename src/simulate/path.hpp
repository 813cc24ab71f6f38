// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How the vehicle swims: a strip, or passes with turns, never quite straight or level.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "nadir/core/frame.hpp"
#include "nadir/core/rigid3.hpp"
#include "profile.hpp"

namespace nadir::simulate {

/// Frame `local`: x to the right of the passes, y along them, z up, zero the seabed's mean.
Rigid3 survey_from_local(const Profile& profile);

/// The vehicle at an instant. The camera sits in the body's origin.
struct Motion {
  Eigen::Vector3d x_in_local = Eigen::Vector3d::Zero();
  Attitude attitude;

  Rigid3 local_from_camera(const Profile& profile) const;
};

/// Exact and continuous in time, so that sensors can be sampled between images.
class Path {
 public:
  /// `ground`: height in local of the hills the vehicle follows, smooth.
  Path(const Profile& profile, std::uint64_t seed, std::function<double(double, double)> ground);

  Motion at(double seconds) const;
  /// Mid-exposure of an image, with a real trigger's jitter.
  double seconds(int image) const;

  /// Position in local x, y and heading (rad, clockwise from local y) at an arc length, no swing.
  struct Course {
    Eigen::Vector2d position;
    double heading;
  };
  Course course(double arc) const;

 private:
  double swing(double seconds, int channel, double fastest) const;

  const Profile& profile_;
  std::uint64_t seed_;
  std::function<double(double, double)> ground_;
};

}  // namespace nadir::simulate
