// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "csv.hpp"
#include "nadir/capture/pose_files.hpp"
#include "nadir/core/check.hpp"
#include "pose_text.hpp"

namespace nadir::capture {
namespace {

struct TimedPose {
  Time time = 0;
  Rigid3 map_from_camera;
  int line = 0;
};

struct Trajectory {
  std::vector<TimedPose> poses;  ///< by time
  bool unscaled = false;
};

TimedPose read_pose(const PoseText& text) {
  const auto words = words_of(text.line());
  if (words.size() != 8) {
    text.fail("has " + std::to_string(words.size()) + " values, expected 8: t tx ty tz qx qy qz qw",
              "give a trajectory in TUM's format");
  }
  const auto number = [&](std::size_t i) {
    constexpr std::array kNames{"a time", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
    return text.real(words[i], kNames[i]);
  };
  // Ordered: of two faults the first is told.
  std::array<double, 8> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = number(i);
  if (!is_time(v[0])) text.fail("the time is beyond 4.6e9 s", "give seconds");
  return {from_seconds(v[0]), text.pose({v[7], v[4], v[5], v[6]}, {v[1], v[2], v[3]}),
          text.number()};
}

Trajectory read_trajectory(const std::filesystem::path& file) {
  Trajectory trajectory;
  PoseText text(file);
  while (text.next()) {
    const auto first = text.line().find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    if (text.line()[first] == '#') {
      trajectory.unscaled |= text.line().find("unscaled") != std::string_view::npos;
    } else {
      trajectory.poses.push_back(read_pose(text));
    }
  }
  auto& poses = trajectory.poses;
  if (poses.empty()) {
    throw InputError(file.string() + ": has no pose; give a trajectory in TUM's format");
  }
  std::ranges::stable_sort(poses, {}, &TimedPose::time);
  const auto twice = std::ranges::adjacent_find(poses, {}, &TimedPose::time);
  if (twice != poses.end()) {
    throw InputError(file.string() + ':' + std::to_string((twice + 1)->line) +
                     ": has the same time as line " + std::to_string(twice->line) +
                     "; take one of them out");
  }
  return trajectory;
}

// A pose must belong to one image only, and an image to one pose. Programs round times to
// milliseconds; 20 ms is half an image's interval at 25 Hz.
Time tolerance(const std::vector<TimedPose>& poses) {
  constexpr Time kRounding = 1'000'000, kMost = 20'000'000;
  Time shortest = 2 * kMost;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    shortest = std::min(shortest, poses[i].time - poses[i - 1].time);
  }
  return std::clamp(shortest / 2, kRounding, kMost);
}

const TimedPose& nearest(const std::vector<TimedPose>& poses, Time time) {
  const auto after = std::ranges::lower_bound(poses, time, {}, &TimedPose::time);
  if (after == poses.begin()) return *after;
  if (after == poses.end()) return poses.back();
  return after->time - time < time - (after - 1)->time ? *after : *(after - 1);
}

// The camera looks at the seabed: where z is up, its optical axis goes down.
bool looks_down(const std::vector<TimedPose>& poses) {
  constexpr double kDown = -0.5;  // within 60 degrees
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TimedPose& p : poses) sum += p.map_from_camera.rotation * Eigen::Vector3d::UnitZ();
  return sum.normalized().z() < kDown;
}

std::string range(Time first, Time last) {
  return std::to_string(seconds(first)) + " to " + std::to_string(seconds(last)) + " s";
}

}  // namespace

GivenPoses read_tum(const std::filesystem::path& file, const std::vector<ListedImage>& images) {
  const auto [poses, unscaled] = read_trajectory(file);
  const Time most = tolerance(poses);
  GivenPoses given{file.string(), {}, looks_down(poses), !unscaled};
  Time first = std::numeric_limits<Time>::max(), last = std::numeric_limits<Time>::min();
  bool any = false;
  for (const ListedImage& image : images) {
    auto& pose = given.map_from_camera.emplace_back();
    if (!image.time) continue;
    first = std::min(first, *image.time);
    last = std::max(last, *image.time);
    const TimedPose& candidate = nearest(poses, *image.time);
    if (std::abs(candidate.time - *image.time) > most) continue;
    pose = candidate.map_from_camera;
    any = true;
  }
  if (!any) {
    const std::string times = first <= last ? range(first, last) : "unknown";
    throw InputError(file.string() + ": has no pose for any of the images: its times are " +
                     range(poses.front().time, poses.back().time) + ", theirs " + times +
                     "; give both on one clock, the images' in timestamps.csv");
  }
  return given;
}

}  // namespace nadir::capture
