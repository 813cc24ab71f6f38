// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nadir/coverage/polygon.hpp"

namespace nadir::coverage {
namespace {

using Eigen::Vector2d, Eigen::Vector3d, Eigen::Vector4d;

// The horizon of a plane seen at a slant lies in the image; next to it all is beyond range.
constexpr double kHorizon = 1e-3;  // of w at the centre

Polygon above_horizon(const Polygon& cells, const Eigen::RowVector3d& w, double least) {
  Polygon kept;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Vector2d &a = cells[i], &b = cells[(i + 1) % cells.size()];
    const double at_a = w * a.homogeneous() - least, at_b = w * b.homogeneous() - least;
    if (at_a >= 0) kept.push_back(a);
    if ((at_a >= 0) != (at_b >= 0)) kept.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return kept;
}

/// Coordinates on a plane, around the point of it next to the camera.
struct PlaneAxes {
  Vector3d foot, x, y;
  Vector2d operator()(const Vector3d& point) const {
    return {x.dot(point - foot), y.dot(point - foot)};
  }
  Vector3d operator()(const Vector2d& at) const { return foot + at.x() * x + at.y() * y; }
};

PlaneAxes axes_of(const Vector3d& point, const Vector3d& along_x, const Vector3d& along_y,
                  const Vector3d& camera) {
  const Vector3d normal = along_x.cross(along_y).normalized();
  const Vector3d x = along_x.normalized();
  return {camera - normal.dot(camera - point) * normal, x, normal.cross(x)};
}

// A circle, from within, to 0.2 % of its radius.
Polygon circle(double radius) {
  constexpr int kCorners = 48;
  Polygon corners;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return corners;
}

}  // namespace

std::optional<Footprint> footprint_of(const Grid& grid) {
  const auto& h = grid.survey_from_grid;
  const double right = grid.bgr.cols - 0.5, bottom = grid.bgr.rows - 0.5;
  const Vector2d centre(0.5 * (right - 0.5), 0.5 * (bottom - 0.5));
  const double central_w = h.row(3) * centre.homogeneous();
  const auto point = [&](const Vector2d& cell) -> Vector3d {
    return Vector4d(h * cell.homogeneous()).hnormalized();
  };
  const auto in_range = [&](const Vector3d& x) {
    return (x - grid.camera_in_survey).norm() <= grid.max_range;
  };
  if (!(central_w > 0) || !in_range(point(centre))) return std::nullopt;

  Footprint footprint{grid.image, grid.submap, {}, 0, 0};
  const Vector2d half_x(0.5, 0), half_y(0, 0.5);
  const Vector3d along_x = point(centre + half_x) - point(centre - half_x);
  const Vector3d along_y = point(centre + half_y) - point(centre - half_y);
  footprint.width = along_x.norm() * grid.bgr.cols;
  footprint.length = along_y.norm() * grid.bgr.rows;
  const Polygon cells =
      above_horizon({{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}}, h.row(3),
                    kHorizon * central_w);
  for (const Vector2d& cell : cells) footprint.corners.push_back(point(cell));
  if (!std::ranges::all_of(footprint.corners, in_range)) {
    const PlaneAxes axes = axes_of(point(centre), along_x, along_y, grid.camera_in_survey);
    const double height = (grid.camera_in_survey - axes.foot).norm();
    Polygon on_plane;
    for (const Vector3d& corner : footprint.corners) on_plane.push_back(axes(corner));
    footprint.corners.clear();
    const double reach = std::sqrt(grid.max_range * grid.max_range - height * height);
    for (const Vector2d& corner : clipped(on_plane, circle(reach)))
      footprint.corners.push_back(axes(corner));
  }
  const auto finite = [](const Vector3d& corner) { return corner.allFinite(); };
  if (footprint.corners.size() < 3 || !std::ranges::all_of(footprint.corners, finite))
    return std::nullopt;
  return footprint;
}

}  // namespace nadir::coverage
