// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Scale from what the vehicle's sensors measure in metres: the altimeter's distance to the ground,
// and changes of depth.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "nadir/core/window.hpp"
#include "nadir/reference/scale_measure.hpp"

namespace nadir::reference {

class SensorScale {
 public:
  /// altimeter_below_camera: metres along the vehicle's down axis, positive when it is nearer to
  /// the ground than the lens.
  explicit SensorScale(double altimeter_below_camera)
      : altimeter_below_camera_(altimeter_below_camera) {}

  /// The shot's own image, when it has a pose, against the tie points of its sub-map's newest
  /// window; depth only when the survey's z is the vertical of the AHRS.
  void observe(const Orientation& orientation);

  /// None before five images of the sub-map told of it, and for an altimeter that has told nothing
  /// but one value in all images.
  std::optional<ScaleMeasure> by_altitude(std::uint32_t submap) const;
  /// None before the depth changed so much that the scale is known to a twentieth.
  std::optional<ScaleMeasure> by_depth(std::uint32_t submap) const;

 private:
  struct Altitude {
    double metres = 0, distance = 0;  ///< by the altimeter; in map units along the same beam
  };
  struct Depth {
    double metres = 0, z = 0;  ///< below the surface; of the camera in the survey frame
  };
  struct Ground {
    std::uint32_t submap = 0;
    SurveyAxes axes = SurveyAxes::none;
    std::vector<TiePoint> tie_points;
  };

  std::optional<double> along_beam(const ImagePose& pose, const Frame& frame) const;

  double altimeter_below_camera_;
  std::optional<Ground> ground_;  ///< of the newest window
  std::map<std::uint32_t, std::vector<Altitude>> altitudes_;
  std::map<std::uint32_t, std::vector<Depth>> depths_;
};

}  // namespace nadir::reference
