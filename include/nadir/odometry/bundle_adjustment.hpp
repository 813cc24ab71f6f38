// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment (paper 3.2): poses and tie points that minimise the robust reprojection error;
// what is marked fixed keeps the reference system and the scale. Also the resection of one image.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "nadir/core/camera_model.hpp"

namespace nadir::odometry {

/// The adjustment as a value: what is given, and after `adjust` what was found.
struct Adjustment {
  struct Image {
    Rigid3 camera_from_map;
    bool fixed = false;
    bool distance_fixed = false;  ///< keeps the length of its translation: the scale of a pair
  };
  struct Point {
    Eigen::Vector3d x_in_map;
    bool fixed = false;
  };
  struct Observation {
    int image = 0;        ///< index into images
    int point = 0;        ///< index into points
    bool right = false;   ///< seen by the right camera of the pair
    Eigen::Vector2d ray;  ///< normalised undistorted coordinates in that camera
    double weight = 1;    ///< of its square
    double error_px = 0;  ///< out: reprojection error; infinite behind the camera
  };
  /// What an AHRS says of one image: roll and pitch.
  struct Vertical {
    int image = 0;
    Eigen::Vector3d up_in_camera;
    double sigma = 0;  ///< radians
  };
  /// What an AHRS says of one image: where it looks about up, the map's z.
  struct Heading {
    int image = 0;
    Eigen::Quaterniond map_from_camera;
    double sigma = 0;  ///< radians
  };
  /// What a depth sensor says of one image.
  struct Height {
    int image = 0;
    double z = 0;      ///< of the camera in the map
    double sigma = 0;  ///< map units
  };
  /// What a laser says of a point near its dot.
  struct Range {
    int image = 0;
    int point = 0;
    double depth = 0;  ///< along the optical axis of the left camera, map units
    double sigma = 0;  ///< relative
  };
  std::vector<Image> images;
  std::vector<Point> points;
  std::vector<Observation> observations;
  std::vector<Vertical> verticals;
  std::vector<Heading> headings;
  std::vector<Height> heights;
  std::vector<Range> ranges;  ///< of points observed in their image
  /// None: found from the verticals, of which then only the differences count.
  std::optional<Eigen::Vector3d> up_in_map;
};

struct AdjustmentSummary {
  double rms_px = 0;  ///< of all observations, weighted as the robust loss saw them
  int iterations = 0;
  bool converged = false;
  bool usable = false;  ///< finite, and the cost did not grow; else nothing was changed
};

struct AdjustmentOptions {
  double robust_px = 1.0;  ///< errors beyond weigh ever less (Cauchy)
  int iterations = 20;
  double tolerance = 1e-5;  ///< of the cost's last change, relative, at which it is good enough
};

AdjustmentSummary adjust(Adjustment& adjustment, const CameraRig& rig,
                         const AdjustmentOptions& options = {});

}  // namespace nadir::odometry
