// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The seabed: a relief, solids on it, coded targets among them. Frame `local` (see path.hpp).
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "path.hpp"
#include "solid.hpp"

namespace nadir::simulate {

/// A height map, bilinear between its nodes, level beyond them.
struct Relief {
  double x0 = 0, y0 = 0, cell = 1;  ///< of node (row 0, column 0), metres
  cv::Mat1f height;                 ///< metres; rows along y, columns along x
  cv::Mat1f light;                  ///< share of the sky not hidden by solids near by

  double z(double x, double y) const;
  Eigen::Vector3d normal(double x, double y) const;
  float light_at(double x, double y) const;
};

/// A coded target: a white disc in the middle of a square plate.
struct Plate {
  std::string id;
  Rigid3 pose;        ///< local_from_slab: its origin is the disc's centre, its z the normal
  double disc, side;  ///< diameter of the disc, side of the plate, metres
};

/// The disc's diameter is this share of the plate's side.
inline constexpr double kDiscShare = 0.28;

struct Scene {
  SceneKind kind{};
  std::uint32_t seed = 0;
  Relief relief;
  std::vector<Solid> solids;
  std::vector<Plate> plates;

  /// What a ray meets first among the ground and the solids given; `guess`: a t near the ground's,
  /// to start from.
  struct Meeting {
    Hit hit;
    const Solid* solid;  ///< null for the ground
  };
  std::optional<Meeting> meet(const Ray& ray, std::span<const Solid* const> solids,
                              double guess) const;
  /// The same among everything.
  std::optional<Meeting> meet(const Ray& ray) const;
  /// The surface seen from above, on the relief's nodes.
  cv::Mat1f top() const;
};

/// Height of the hills alone, which the vehicle follows.
double hills(const Profile& profile, std::uint64_t seed, double x, double y);

/// A scene large enough for the first `images` images along a path.
Scene make_scene(SceneKind kind, std::uint64_t seed, const Path& path, int images);

}  // namespace nadir::simulate
