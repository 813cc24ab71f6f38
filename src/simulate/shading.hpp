// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What colour a place on the seabed has, and what light of it reaches the camera.
#pragma once

#include <opencv2/core/matx.hpp>
#include <vector>

#include "scene.hpp"

namespace nadir::simulate {

/// Linear B G R reflectance and the fine relief's tilt of the normal.
struct Skin {
  cv::Vec3f albedo;
  Eigen::Vector3d normal;
};

/// footprint: side of the area to be averaged, metres.
Skin skin(const Scene& scene, const Scene::Meeting& meeting, double footprint);

/// Lamps where they are at one exposure, in local; the water between.
struct Light {
  struct Source {
    Eigen::Vector3d position, direction;
    float power, sharpness;
  };
  struct Beam {
    Eigen::Vector3d origin, direction;
  };
  std::vector<Source> sources;
  Water water;
  std::vector<Beam> beams;  ///< green lasers
};

/// Single scattering: radiance towards the eye of a place with this skin; `open`: the share of
/// daylight that reaches it.
cv::Vec3f radiance(const Light& light, const Skin& skin, const Eigen::Vector3d& place,
                   const Eigen::Vector3d& eye, float open);

}  // namespace nadir::simulate
