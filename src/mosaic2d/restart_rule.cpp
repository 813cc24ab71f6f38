// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "restart_rule.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace nadir::mosaic2d {
namespace {

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

std::string line(const char* format, double value) {
  char text[96];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

std::string RestartRule::departure(const Stand& stand) const {
  const double angle = angle_deg(first_.plane.normal, stand.plane.normal);
  if (angle > config_.restart_angle_deg) return line("the seabed turned by %.0f degrees", angle);

  // Both planes cut the vertical line through the image centre; normals there have n_z > 0.
  const double offset = std::abs(first_.plane.distance(stand.footprint.centre)) /
                        first_.plane.normal.z() / stand.footprint.viewing_distance;
  if (offset > config_.restart_offset) {
    return line("the seabed rose or fell by %.0f %% of the viewing distance", 100 * offset);
  }
  constexpr double kSmooth = 0.01;  // growth below a hundredth of the distance is no news
  const double rms = stand.plane.rms / stand.footprint.viewing_distance;
  const double first_rms = first_.plane.rms / first_.footprint.viewing_distance;
  if (rms > config_.restart_rms * std::max(first_rms, kSmooth)) {
    return line("the seabed grew rougher, %.1f %% of the viewing distance", 100 * rms);
  }
  const double zoom = stand.footprint.sampling_distance / first_.footprint.sampling_distance;
  if (zoom > config_.restart_zoom || zoom * config_.restart_zoom < 1) {
    return line("the images' resolution on the seabed changed by a factor of %.1f", zoom);
  }
  return {};
}

std::string RestartRule::reason(const Stand& stand) {
  if (stand.submap != first_.submap) return "a new sub-map began";
  std::string departed = departure(stand);
  departed_ = departed.empty() ? 0 : departed_ + 1;
  return departed_ >= config_.restart_after ? departed : std::string{};
}

}  // namespace nadir::mosaic2d
