// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/lanes.hpp"

#include <cmath>

namespace nadir::coverage {
namespace {

using Eigen::Vector2d;

constexpr double kMostLanes = 65535;

/// Where a vehicle is against one lane, along and across it in the lane's direction.
struct Against {
  double along = 0, right = 0, heading = 0;  ///< heading: cosine to the lane's direction
};

bool runs_back(std::size_t lane) { return lane % 2 != 0; }

Against against(const Plan& plan, double width, std::size_t lane, const Vector2d& position,
                const Vector2d& velocity) {
  const Vector2d from_corner = position - plan.corner;
  const double middle = (static_cast<double>(lane) + 0.5) * width;
  const double speed = velocity.norm();
  Against there{plan.along().dot(from_corner), plan.right().dot(from_corner) - middle,
                speed > 0 ? plan.along().dot(velocity) / speed : 0};
  if (runs_back(lane)) return {plan.length - there.along, -there.right, -there.heading};
  return there;
}

bool is_past_an_end(const Against& there, double length, double slack) {
  return there.along < -slack || there.along > length + slack;
}

}  // namespace

Vector2d Plan::along() const { return {std::sin(bearing), std::cos(bearing)}; }
Vector2d Plan::right() const { return {std::cos(bearing), -std::sin(bearing)}; }

Polygon Plan::ground() const {
  const Vector2d ahead = length * along(), aside = width * right();
  return {corner, corner + ahead, corner + ahead + aside, corner + aside};
}

std::vector<Lane> lanes_of(const Plan& plan) {
  constexpr double kRounding = 1e-9;
  const double count = std::ceil(plan.width / plan.lane_spacing - kRounding);
  if (!(plan.lane_spacing > 0) || !(count >= 1 && count <= kMostLanes)) return {};
  std::vector<Lane> lanes(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const Vector2d begin =
        plan.corner + (static_cast<double>(i) + 0.5) * plan.width / count * plan.right();
    const Vector2d end = begin + plan.length * plan.along();
    lanes[i] = runs_back(i) ? Lane{end, begin} : Lane{begin, end};
  }
  return lanes;
}

Polygon strip_of(const Plan& plan, std::size_t lanes, std::size_t lane) {
  Plan strip = plan;
  strip.width = plan.width / static_cast<double>(lanes);
  strip.corner += static_cast<double>(lane) * strip.width * plan.right();
  return strip.ground();
}

std::optional<LaneKeeper::OnLane> LaneKeeper::observe(const Plan& plan, std::size_t lanes,
                                                      const Vector2d& position,
                                                      const Vector2d& velocity) {
  if (lane_ && *lane_ >= lanes) lane_.reset();
  if (lanes == 0) return std::nullopt;
  const double width = plan.width / static_cast<double>(lanes);
  constexpr double kAlong = 0.5;   // cosine
  constexpr double kStrip = 0.75;  // widths from the middle
  if (lane_) {
    const Against there = against(plan, width, *lane_, position, velocity);
    if (there.heading < -kAlong || std::abs(there.right) > kStrip * width ||
        is_past_an_end(there, plan.length, width))
      lane_.reset();
  }
  if (!lane_) {
    const double strip = std::floor(plan.right().dot(position - plan.corner) / width);
    if (!(strip >= 0 && strip < static_cast<double>(lanes))) return std::nullopt;
    const auto lane = static_cast<std::uint16_t>(strip);
    const Against there = against(plan, width, lane, position, velocity);
    if (there.heading < kAlong || is_past_an_end(there, plan.length, 0)) return std::nullopt;
    lane_ = lane;
  }
  return OnLane{*lane_, against(plan, width, *lane_, position, velocity).right};
}

}  // namespace nadir::coverage
