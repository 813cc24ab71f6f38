// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Scale from what the vehicle's sensors measure in metres: the altimeter's distance to the ground,
// and changes of depth.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nadir/core/window.hpp"
#include "nadir/reference/scale_measure.hpp"

namespace nadir::reference {

/// Why a sensor gives no scale.
struct SensorFault {
  ScaleSource source = ScaleSource::none;  ///< that gives no scale from here on; none: only now
  std::string message, remedy;             ///< of an alert
};

class SensorScale {
 public:
  /// altimeter_below_camera: metres along the vehicle's down axis, positive when it is nearer to
  /// the ground than the lens.
  explicit SensorScale(double altimeter_below_camera)
      : altimeter_below_camera_(altimeter_below_camera) {}

  /// The shot's own image, when it has a pose, against the tie points of its sub-map's newest
  /// window; depth only when the survey's z is the vertical of the AHRS.
  void observe(const Orientation& orientation);

  /// None before five images of the sub-map told of it, while its noise leaves the scale less than
  /// known to a twentieth, and for an altimeter that has told nothing but one value in all images.
  std::optional<ScaleMeasure> by_altitude(std::uint32_t submap) const;
  /// None before the depth changed so much that the scale is known to a twentieth, by more than the
  /// map's tilt of some degrees can explain.
  std::optional<ScaleMeasure> by_depth(std::uint32_t submap) const;

  /// After observe(): of the altimeter or the depth gauge that hangs while the images move towards
  /// the ground or from it, that has nothing to do with what they see, of an altimeter without echo
  /// or in another unit, of a depth that grows upwards; over 15 images and 5 s at least. Once each;
  /// a sensor told of gives no scale any more, but for missing echoes.
  std::vector<SensorFault> new_faults(std::uint32_t submap);

  /// The vertical of maps whose axes are the AHRS's proved wrong: depths say nothing from here on.
  void forget_vertical();

 private:
  struct Altitude {
    double metres = 0, distance = 0;  ///< by the altimeter; in map units along the same beam
    Time time = 0;
  };
  struct Depth {
    double metres = 0;                                   ///< below the surface
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the camera in the survey frame
    double distance = 0;  ///< of the tie points along the view, median, map units
    bool metric = false;  ///< map units are metres
    Time time = 0;
  };
  struct Ground {
    std::uint32_t submap = 0;
    SurveyAxes axes = SurveyAxes::none;
    std::vector<TiePoint> tie_points;
    bool metric = false;
  };

  std::optional<SensorFault> altimeter_fault(std::uint32_t submap) const;
  std::optional<SensorFault> depth_fault(std::uint32_t submap) const;
  std::optional<SensorFault> echo_fault() const;
  void hear(bool echo, Time time);
  std::optional<double> along_beam(const ImagePose& pose, const Frame& frame) const;

  double altimeter_below_camera_;
  std::optional<Ground> ground_;  ///< of the newest window
  std::map<std::uint32_t, std::vector<Altitude>> altitudes_;
  std::map<std::uint32_t, std::vector<Depth>> depths_;
  std::size_t without_echo_ = 0;  ///< images in a row at an altitude of 0
  Time silent_since_ = 0, silent_ = 0;
  bool altimeter_fails_ = false, depth_fails_ = false, echo_told_ = false;  ///< told
  bool without_vertical_ = false;
};

}  // namespace nadir::reference
