// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "solid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "noise.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector3d;

// Radius of a blob in a direction of its unit sphere (smooth: 1).
double radius_towards(const Blob& blob, const Vector3d& p) {
  const Vector3d direction = p.normalized();
  double radius = 1;
  if (blob.roughness > 0) {
    const Vector3d place = direction * blob.frequency;
    radius += blob.roughness *
              (0.65 * noise(place, blob.seed) + 0.35 * noise(Vector3d(2.3 * place), blob.seed + 1));
  }
  if (blob.arms > 0) {
    const double angle = std::atan2(direction.y(), direction.x());
    const double tip = std::abs(std::cos(0.5 * blob.arms * angle));
    radius *= 0.3 + 0.7 * tip * tip;
  }
  return radius;
}

double outside(const Blob& blob, const Vector3d& p) { return p.norm() - radius_towards(blob, p); }

Vector3d normal_at(const Blob& blob, const Vector3d& p) {
  if (blob.roughness <= 0) return (blob.unit_from_local.transpose() * p).normalized();
  constexpr double kStep = 2e-3;
  const double here = outside(blob, p);
  const Vector3d gradient(outside(blob, p + kStep * Vector3d::UnitX()) - here,
                          outside(blob, p + kStep * Vector3d::UnitY()) - here,
                          outside(blob, p + kStep * Vector3d::UnitZ()) - here);
  return (blob.unit_from_local.transpose() * gradient).normalized();
}

// Between a t outside and a t inside the surface (regula falsi).
double close_in(const Blob& blob, const Ray& ray, double out, double gap_out, double in,
                double gap_in) {
  constexpr int kSteps = 8;
  constexpr double kTouch = 5e-5;  // of the radius
  double t = in;
  for (int i = 0; i < kSteps; ++i) {
    t = out + (in - out) * gap_out / (gap_out - gap_in);
    const double gap = outside(blob, ray.at(t));
    if (std::abs(gap) < kTouch) break;
    (gap > 0 ? out : in) = t;
    (gap > 0 ? gap_out : gap_in) = gap;
  }
  return t;
}

// Walks from the enclosing sphere towards the rough surface by a share of the distance that hardly
// a bump exceeds (sphere tracing, Hart 1996), longer where the surface was seen to come slowly.
std::optional<double> walk(const Blob& blob, const Ray& ray, double enter, double leave) {
  constexpr double kLeast = 0.005, kLongest = 2;  // of the radius; of the careful step
  const double share = (blob.arms > 0 ? 0.3 : 0.6) / ray.direction.norm();
  double t = enter, gap = outside(blob, ray.at(t)), slope = 0;  // fall of the gap per t
  while (t < leave) {
    const double careful = share * std::max(gap, kLeast);
    const double expected = slope > 0 ? 1.05 * gap / slope : careful;
    const double next = t + std::clamp(expected, careful, kLongest * careful);
    const double gap_next = outside(blob, ray.at(next));
    if (gap_next <= 0) return close_in(blob, ray, t, gap, next, gap_next);
    slope = (gap - gap_next) / (next - t);
    t = next, gap = gap_next;
  }
  return std::nullopt;
}

std::optional<Hit> intersect(const Blob& blob, const Ray& ray) {
  const Ray unit{blob.unit_from_local * (ray.origin - blob.centre),
                 blob.unit_from_local * ray.direction};
  const double bound = 1 + blob.roughness;
  const double a = unit.direction.squaredNorm(), b = unit.origin.dot(unit.direction);
  const double square = b * b - a * (unit.origin.squaredNorm() - bound * bound);
  if (square <= 0) return std::nullopt;
  const double root = std::sqrt(square), enter = (-b - root) / a;
  if (enter <= 0) return std::nullopt;
  const bool smooth = blob.roughness <= 0 && blob.arms == 0;
  const auto t = smooth ? std::optional(enter) : walk(blob, unit, enter, (-b + root) / a);
  if (!t) return std::nullopt;
  const Vector3d place = unit.at(*t);
  return Hit{*t, normal_at(blob, place), place};
}

// The slab method (Kay and Kajiya 1986).
std::optional<Hit> intersect(const Slab& slab, const Ray& ray) {
  const Eigen::Quaterniond turn = slab.local_from_slab.rotation.conjugate();
  const Ray own{turn * (ray.origin - slab.local_from_slab.translation), turn * ray.direction};
  const Vector3d low(-slab.half.x(), -slab.half.y(), -slab.half.z());
  const Vector3d high(slab.half.x(), slab.half.y(), 0);
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - own.origin[axis]) / own.direction[axis];
    const double b = (high[axis] - own.origin[axis]) / own.direction[axis];
    if (std::min(a, b) > enter) enter = std::min(a, b), face = axis;
    leave = std::min(leave, std::max(a, b));
  }
  if (face < 0 || !(enter < leave)) return std::nullopt;
  Vector3d normal = Vector3d::Zero();
  normal[face] = own.direction[face] > 0 ? -1 : 1;
  return Hit{enter, slab.local_from_slab.rotation * normal, own.at(enter)};
}

}  // namespace

std::optional<Hit> Solid::hit(const Ray& ray) const {
  return std::visit([&](const auto& s) { return intersect(s, ray); }, shape);
}

Solid make_blob(Material material, const Vector3d& centre, const Vector3d& radii,
                const Eigen::Quaterniond& rotation, float roughness, float frequency,
                std::uint32_t seed) {
  const Eigen::Matrix3d unit_from_local =
      radii.cwiseInverse().asDiagonal() * rotation.conjugate().toRotationMatrix();
  return {material, centre, radii.maxCoeff() * (1 + roughness), random_of(seed, 0),
          Blob{centre, unit_from_local, roughness, frequency, 0, seed}};
}

Solid make_slab(Material material, const Rigid3& local_from_slab, const Vector3d& half,
                std::uint32_t seed) {
  const Vector3d middle = local_from_slab * Vector3d(0, 0, -half.z() / 2);
  const double radius = Vector3d(half.x(), half.y(), half.z() / 2).norm();
  return {material, middle, radius, random_of(seed, 0), Slab{local_from_slab, half, seed}};
}

}  // namespace nadir::simulate
