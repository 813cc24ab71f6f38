// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where a survey lies on the earth: the position of its origin, and the UTM grid around it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "nadir/core/tile.hpp"

namespace nadir::reference {

/// WGS 84.
struct Geodetic {
  double latitude_deg = 0, longitude_deg = 0;  ///< north and east positive
  double height = 0;                           ///< above the ellipsoid, metres
};

/// "LATITUDE LONGITUDE" or "LATITUDE LONGITUDE HEIGHT"; none when empty. Throws InputError when
/// malformed or where UTM has no zone.
std::optional<Geodetic> parse_origin(const std::string& text);

/// A survey whose y axis is the grid's north, in metres, with its origin at a position. The map is
/// a scale and a shift: what it leaves out grows with the square of the distance from the origin,
/// by (easting - 500 km) / (2 R^2), and is 5 mm at 1 km where it is largest.
class UtmGrid {
 public:
  /// Throws InputError where UTM has no zone.
  explicit UtmGrid(const Geodetic& origin);

  const Geodetic& origin() const { return origin_; }
  int zone() const { return zone_; }  ///< 1 to 60
  bool is_north() const { return north_; }
  int epsg() const { return (north_ ? 32600 : 32700) + zone_; }
  /// From true north to the grid's at the origin, clockwise seen from above, radians.
  double convergence() const { return convergence_; }
  /// Of the grid at the origin and its height: grid metres per survey metre.
  double scale() const { return scale_; }

  /// Easting and northing, metres.
  Eigen::Vector2d operator()(const Eigen::Vector2d& x_in_survey) const {
    return shift_ + scale_ * x_in_survey;
  }
  WorldFile operator()(const WorldFile& survey) const;
  /// None beyond where the grid has an inverse, thousands of kilometres away.
  std::optional<Geodetic> geodetic(const Eigen::Vector3d& x_in_survey) const;
  /// Survey x and y of a place; none where the grid's zone does not reach.
  std::optional<Eigen::Vector2d> in_survey(const Geodetic& place) const;

 private:
  Geodetic origin_;
  int zone_ = 0;
  bool north_ = true;
  double convergence_ = 0, scale_ = 1;
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();
};

}  // namespace nadir::reference
