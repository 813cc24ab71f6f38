// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The figures of the four scenes, in one table: vehicle, camera, lamps, water, relief.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "nadir/core/camera_model.hpp"
#include "nadir/simulate/options.hpp"

namespace nadir::simulate {

/// Rides on the left camera, in its frame. Radiant intensity falls as cos(angle)^sharpness.
struct Lamp {
  Eigen::Vector3d position, direction;
  float power, sharpness;
};

/// Colours are linear B G R throughout.
struct Water {
  cv::Vec3f attenuation;  ///< 1/m, along the light's whole path
  cv::Vec3f veil;         ///< radiance of an infinite depth of lit water
  cv::Vec3f ambient;      ///< irradiance of daylight at the seabed
};

struct Profile {
  int images;
  double interval;         ///< s
  double spacing;          ///< m along the path between images
  double altitude;         ///< m above the seabed
  double azimuth;          ///< of the passes, rad clockwise from north
  double pass_length;      ///< m; 0: one straight strip
  double pass_gap;         ///< m between neighbouring passes
  double wobble;           ///< rad, largest roll, pitch and heading swing
  double heave;            ///< m, largest swing of altitude
  Eigen::Vector3d origin;  ///< survey_from_local translation; z = -(depth of the seabed)
  double cell;             ///< m, of the height map
  std::vector<Eigen::Vector2d> relief;  ///< size and amplitude of each octave, m
  CameraModel camera, right_camera;
  double baseline;  ///< m
  std::vector<Lamp> lamps;
  Water water;
  double snow;     ///< particles per image
  int jpeg;        ///< quality
  double target;   ///< m, side of a coded plate
  double targets;  ///< m of path per coded plate
};

const Profile& profile(SceneKind scene);

/// The camera or pair of a survey, scaled as asked.
CameraRig rig(const Options& options);

}  // namespace nadir::simulate
