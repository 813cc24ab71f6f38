// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include <algorithm>

namespace nadir::odometry {

std::optional<Rigid3> predict(std::span<const Moment> track, Time time) {
  if (track.empty()) return std::nullopt;
  const Moment& last = track.back();
  if (track.size() < 2) return last.camera_from_map;
  const Moment& before = track[track.size() - 2];
  if (last.time <= before.time) return last.camera_from_map;
  const double share =
      std::clamp(seconds(time - last.time) / seconds(last.time - before.time), 0.0, 3.0);
  const Rigid3 step = last.camera_from_map * before.camera_from_map.inverse();
  const Rigid3 onward{Eigen::Quaterniond::Identity().slerp(share, step.rotation),
                      share * step.translation};
  return onward * last.camera_from_map;
}

double shift_since_last(const Map& map, const Resection& resection) {
  std::vector<double> shifts;
  for (const Seen& s : resection.seen) {
    const auto before = map.rig->left.project(map.last().camera_from_map * map.point(s.point).x);
    if (before) shifts.push_back((s.pixel - *before).norm());
  }
  if (shifts.empty()) return 1e9;
  const auto middle = shifts.begin() + static_cast<std::ptrdiff_t>(shifts.size() / 2);
  std::nth_element(shifts.begin(), middle, shifts.end());
  return *middle;
}

}  // namespace nadir::odometry
