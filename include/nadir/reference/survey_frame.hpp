// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where a sub-map lies in the survey frame: scale, axes, origin (paper 3 and 3.3).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "nadir/core/surface.hpp"
#include "nadir/core/window.hpp"

namespace nadir::reference {

struct Config {
  bool attitude = true;  ///< take the vertical and north from the AHRS when images have attitudes
  double stereo_matching_px = 0.3;  ///< 1 sigma of a disparity, for the sigma of the stereo scale
  double dead_reckoning_max_s = 5;  ///< beyond this the last velocity says nothing any more

  /// Between a map's plane and the mean viewing direction; the camera looks down, so a plane
  /// steeper than that is an artefact of a few images with doubtful calibration, or a wall, and
  /// gives no vertical.
  double max_plane_tilt_deg = 35;

  void check() const;
};

/// Places the first sub-map at its own centroid, and every later one by attitude and dead reckoning
/// from what was last seen, marked uncertain. Mono maps have no scale: the first is sized so that
/// the mean viewing distance of its tie points is 1, later ones so that the distance to the seabed
/// continues.
class SurveyFrame {
 public:
  /// The plane of a window in the window's own frame, or none.
  using PlaneOf = std::function<std::optional<Plane>(const Window&)>;

  SurveyFrame(Config config, PlaneOf plane_of);

  /// initial: in the odometry frame of the new sub-map; frames: of initial.images, in their order.
  SubmapPlacement place(const Window& initial,
                        const std::vector<std::shared_ptr<const Frame>>& frames);

  /// Remembers the newest pose and viewing distance, from which a later sub-map is dead-reckoned.
  void observe(const Orientation& orientation);

  SurveyAxes axes() const { return axes_; }
  Scale scale() const { return scale_; }

 private:
  struct LastSeen {
    ImagePose pose;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< survey units per second
    std::optional<double> depth;  ///< of the vehicle below the surface, metres
  };

  Eigen::Quaterniond upright(const Window& initial);
  Eigen::Vector3d dead_reckoned(const ImagePose& first, const Frame& frame) const;

  Config config_;
  PlaneOf plane_of_;
  SurveyAxes axes_ = SurveyAxes::none;
  Scale scale_;
  std::optional<LastSeen> last_;
  double viewing_distance_ = 1;  ///< median over the last window, survey units
};

}  // namespace nadir::reference
