// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "noise.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector3d;

struct Bilinear {
  int column, row;
  float u, v;
};

Bilinear locate(const Relief& relief, double x, double y) {
  const double c = std::clamp((x - relief.x0) / relief.cell, 0.0, relief.height.cols - 1.001);
  const double r = std::clamp((y - relief.y0) / relief.cell, 0.0, relief.height.rows - 1.001);
  const int column = static_cast<int>(c), row = static_cast<int>(r);
  return {column, row, static_cast<float>(c - column), static_cast<float>(r - row)};
}

float sample(const cv::Mat1f& grid, const Bilinear& at) {
  const float* low = grid.ptr<float>(at.row) + at.column;
  const float* high = grid.ptr<float>(at.row + 1) + at.column;
  const float a = low[0] + at.u * (low[1] - low[0]), b = high[0] + at.u * (high[1] - high[0]);
  return a + at.v * (b - a);
}

// The relief is gentle, so a ray from above meets it once: the secant finds it in a few steps.
std::optional<Hit> meet_ground(const Relief& relief, const Ray& ray, double guess) {
  constexpr int kSteps = 30;
  constexpr double kTouch = 2e-6;  // metres
  if (!(ray.direction.z() < 0)) return std::nullopt;
  const auto gap = [&](double t) {
    const Vector3d x = ray.at(t);
    return x.z() - relief.z(x.x(), x.y());
  };
  double t0 = guess, g0 = gap(t0), t1 = t0 - g0 / ray.direction.z(), g1 = gap(t1);
  for (int i = 0; i < kSteps && std::abs(g1) > kTouch; ++i) {
    const double slope = g1 != g0 ? (g1 - g0) / (t1 - t0) : ray.direction.z();
    t0 = t1, g0 = g1;
    t1 -= g1 / std::min(slope, 0.25 * ray.direction.z());
    g1 = gap(t1);
  }
  const Vector3d x = ray.at(t1);
  return Hit{t1, relief.normal(x.x(), x.y()), x};
}

}  // namespace

double Relief::z(double x, double y) const { return sample(height, locate(*this, x, y)); }

float Relief::light_at(double x, double y) const { return sample(light, locate(*this, x, y)); }

// Central differences at the four nodes around, interpolated: no facets.
Vector3d Relief::normal(double x, double y) const {
  const Bilinear at = locate(*this, x, y);
  const int left = std::max(at.column - 1, 0), right = std::min(at.column + 2, height.cols - 1);
  const int low = std::max(at.row - 1, 0), high = std::min(at.row + 2, height.rows - 1);
  const float *r0 = height.ptr<float>(low), *r1 = height.ptr<float>(at.row);
  const float *r2 = height.ptr<float>(at.row + 1), *r3 = height.ptr<float>(high);
  const int c1 = at.column, c2 = at.column + 1;
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const float dx = mix(mix(r1[c2] - r1[left], r1[right] - r1[c1], at.u),
                       mix(r2[c2] - r2[left], r2[right] - r2[c1], at.u), at.v);
  const float dy = mix(mix(r2[c1] - r0[c1], r2[c2] - r0[c2], at.u),
                       mix(r3[c1] - r1[c1], r3[c2] - r1[c2], at.u), at.v);
  return Vector3d(-static_cast<double>(dx), -static_cast<double>(dy), 2 * cell).normalized();
}

std::optional<Scene::Meeting> Scene::meet(const Ray& ray, std::span<const Solid* const> among,
                                          double guess) const {
  std::optional<Meeting> nearest;
  if (const auto ground = meet_ground(relief, ray, guess)) nearest = {*ground, nullptr};
  for (const Solid* solid : among) {
    const auto hit = solid->hit(ray);
    if (hit && (!nearest || hit->t < nearest->hit.t)) nearest = {*hit, solid};
  }
  return nearest;
}

std::optional<Scene::Meeting> Scene::meet(const Ray& ray) const {
  std::vector<const Solid*> near;
  const Vector3d along = ray.direction.normalized();
  for (const Solid& solid : solids) {
    if ((solid.centre - ray.origin).cross(along).norm() < solid.radius) near.push_back(&solid);
  }
  return meet(ray, near, -ray.origin.z() / ray.direction.z());
}

cv::Mat1f Scene::top() const {
  cv::Mat1f surface = relief.height.clone();
  const auto index = [&](double x, double origin, int size) {
    return std::clamp(static_cast<int>(std::floor((x - origin) / relief.cell)), 0, size - 1);
  };
  for (const Solid& solid : solids) {
    const double r = solid.radius;
    const double above = solid.centre.z() + r + 1;
    const int last_row = index(solid.centre.y() + r, relief.y0, surface.rows);
    const int last_column = index(solid.centre.x() + r, relief.x0, surface.cols);
    for (int row = index(solid.centre.y() - r, relief.y0, surface.rows); row <= last_row; ++row) {
      for (int c = index(solid.centre.x() - r, relief.x0, surface.cols); c <= last_column; ++c) {
        const Ray down{{relief.x0 + c * relief.cell, relief.y0 + row * relief.cell, above},
                       {0, 0, -1}};
        const auto hit = solid.hit(down);
        if (hit) surface(row, c) = std::max(surface(row, c), static_cast<float>(above - hit->t));
      }
    }
  }
  return surface;
}

}  // namespace nadir::simulate
