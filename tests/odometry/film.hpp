// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images of the flat seabed along a way.
#pragma once

#include <cmath>
#include <vector>

#include "odometry/ground.hpp"

namespace nadir::odometry {

using Film = std::vector<std::shared_ptr<const Shot>>;

inline std::vector<Rigid3> swimming_path(int images, double step = 0.2) {
  std::vector<Rigid3> path;
  for (int i = 0; i < images; ++i) {
    path.push_back(looking_down(step * i, 0.1 * std::sin(0.7 * i), 1 + 0.05 * std::cos(0.5 * i),
                                0.15 * std::sin(0.4 * i), 0.03 * std::sin(1.1 * i)));
  }
  return path;
}

inline Film film(const CameraRig& rig, const std::vector<Rigid3>& path, std::uint64_t first = 0) {
  static const Ground ground;
  const auto shared = std::make_shared<const CameraRig>(rig);
  Film shots;
  for (std::size_t i = 0; i < path.size(); ++i) {
    shots.push_back(ground.shot(first + i, shared, path[i]));
  }
  return shots;
}

/// A film whose frames are changed: change(original film, index, frame).
template <class Change>
Film with_frames(Film shots, Change change) {
  const Film original = shots;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    auto frame = std::make_shared<Frame>(*original[i]->frame);
    change(original, i, *frame);
    auto shot = std::make_shared<Shot>(*original[i]);
    shot->frame = std::move(frame);
    shots[i] = std::move(shot);
  }
  return shots;
}

}  // namespace nadir::odometry
