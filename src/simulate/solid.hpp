// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The things on the seabed: lumpy ellipsoids and slabs, each intersected by rays exactly as it is
// written down in the truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <variant>

#include "nadir/core/rigid3.hpp"

namespace nadir::simulate {

enum class Material { ground, rock, coral, urchin, starfish, ceramic, box, plate, target };

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< any length; t counts in it

  Eigen::Vector3d at(double t) const { return origin + t * direction; }
};

/// An ellipsoid whose radius varies with direction: boulder, coral head, urchin, jar, star.
struct Blob {
  Eigen::Vector3d centre;
  Eigen::Matrix3d unit_from_local;  ///< maps the smooth ellipsoid to the unit sphere
  float roughness = 0;              ///< swing of the radius, share of it
  float frequency = 2;              ///< lumps per radian
  int arms = 0;                     ///< of a star in the unit's x, y; 0 for none
  std::uint32_t seed = 0;
};

/// A box; its top face carries a pattern. The slab's frame: origin in the top's centre, z up.
struct Slab {
  Rigid3 local_from_slab;
  Eigen::Vector3d half;  ///< half width, half length, thickness (below the top)
  std::uint32_t seed = 0;
};

struct Hit {
  double t;
  Eigen::Vector3d normal;  ///< unit, local, towards the ray's origin
  Eigen::Vector3d place;   ///< where in the solid's own frame: unit sphere, slab, or local (ground)
};

struct Solid {
  Material material;
  Eigen::Vector3d centre;  ///< of a sphere around it, local
  double radius;
  float tint = 0;  ///< 0 to 1, varies the colour
  std::variant<Blob, Slab> shape;

  std::optional<Hit> hit(const Ray& ray) const;
};

/// radii along the axes of `rotation`, metres.
Solid make_blob(Material material, const Eigen::Vector3d& centre, const Eigen::Vector3d& radii,
                const Eigen::Quaterniond& rotation, float roughness, float frequency,
                std::uint32_t seed);
Solid make_slab(Material material, const Rigid3& local_from_slab, const Eigen::Vector3d& half,
                std::uint32_t seed);

}  // namespace nadir::simulate
