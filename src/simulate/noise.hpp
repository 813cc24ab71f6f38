// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Procedural noise, a pure function of the place: textures need no storage and have no seam.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace nadir::simulate {

/// Value noise on the unit lattice, twice differentiable, in [-1, 1].
float noise(double x, double y, std::uint32_t seed);
float noise(const Eigen::Vector3d& x, std::uint32_t seed);

/// How much of a pattern of this size survives a pixel of this footprint (metres), 0 to 1:
/// what a pixel cannot resolve is left out, not aliased.
float visible(double size, double footprint);

/// Octaves of noise from the size `largest` down by halves, amplitude falling by `persistence`,
/// band-limited to the footprint; standard deviation about 0.3.
struct Fractal {
  double largest;  ///< metres
  int octaves;
  float persistence;
  std::uint32_t seed;

  float operator()(double x, double y, double footprint) const;
};

/// The nearest seed point of a jittered lattice (Worley 1996): stones, cells, specks.
struct Cell {
  float distance;        ///< to the seed point, cells
  float border;          ///< second nearest less nearest distance: 0 between two cells
  Eigen::Vector2f from;  ///< from the seed point, cells
  std::uint32_t id;
};
Cell cell(double x, double y, std::uint32_t seed);

/// The k-th random number of an id, in [0, 1).
float random_of(std::uint32_t id, std::uint32_t k);

}  // namespace nadir::simulate
