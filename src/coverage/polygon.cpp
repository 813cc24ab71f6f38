// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/polygon.hpp"

#include <cmath>

namespace nadir::coverage {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Positive when the corners turn from x to y.
double signed_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
  return twice / 2;
}

// The part to the left of a line (of x towards y), by Sutherland and Hodgman.
Polygon left_of(const Polygon& polygon, const Vector2d& from, const Vector2d& along) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = cross(along, a - from), at_b = cross(along, b - from);
    if (at_a >= 0) kept.push_back(a);
    if ((at_a >= 0) != (at_b >= 0)) kept.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return kept;
}

}  // namespace

double area(const Polygon& polygon) { return polygon.empty() ? 0 : std::abs(signed_area(polygon)); }

Polygon clipped(const Polygon& polygon, const Polygon& by) {
  if (by.size() < 3) return {};
  const double turn = signed_area(by) < 0 ? -1 : 1;
  Polygon left = polygon;
  for (std::size_t i = 0; i < by.size() && !left.empty(); ++i)
    left = left_of(left, by[i], turn * (by[(i + 1) % by.size()] - by[i]));
  return left;
}

}  // namespace nadir::coverage
