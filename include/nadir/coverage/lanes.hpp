// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A plan: a rectangle of ground, swum lane by lane, there and back.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "nadir/coverage/polygon.hpp"

namespace nadir::coverage {

/// x and y of the survey frame, survey units. Lanes run along its length; the first begins at the
/// corner, and each next one lies to the right, seen along the bearing.
struct Plan {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();
  double length = 0, width = 0;
  double bearing = 0;       ///< of the length, radians clockwise from survey y
  double lane_spacing = 0;  ///< at most; 0: by the footprint
  bool operator==(const Plan&) const = default;

  Eigen::Vector2d along() const;  ///< unit
  Eigen::Vector2d right() const;
  Polygon ground() const;  ///< beginning at the corner
};

/// A lane's middle, from where it begins to where it ends.
struct Lane {
  Eigen::Vector2d from = Eigen::Vector2d::Zero(), to = Eigen::Vector2d::Zero();
};

/// Strips of one width that make up the plan's, as wide as lane_spacing allows; every other one
/// runs back. None without a spacing, or when they would be more than 65535.
std::vector<Lane> lanes_of(const Plan& plan);
/// A lane's strip.
Polygon strip_of(const Plan& plan, std::size_t lanes, std::size_t lane);

/// Which lane a vehicle swims.
class LaneKeeper {
 public:
  struct OnLane {
    std::uint16_t lane = 0;
    double off = 0;  ///< how far to the right of its middle, seen along its direction
  };

  /// A lane is entered in its strip, when the vehicle moves along it (within 60 degrees), and left
  /// when it turns back, leaves the strip by more than a quarter of its width, or swims past an end
  /// by more than its width. velocity: of any size; 0 keeps the lane.
  std::optional<OnLane> observe(const Plan& plan, std::size_t lanes,
                                const Eigen::Vector2d& position, const Eigen::Vector2d& velocity);

 private:
  std::optional<std::uint16_t> lane_;
};

}  // namespace nadir::coverage
