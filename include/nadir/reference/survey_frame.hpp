// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where a sub-map lies in the survey frame: scale, axes, origin (paper 3 and 3.3).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nadir/core/revision.hpp"
#include "nadir/core/surface.hpp"
#include "nadir/core/window.hpp"
#include "nadir/reference/attitude_check.hpp"
#include "nadir/reference/geodetic.hpp"
#include "nadir/reference/scale_claims.hpp"

namespace nadir::reference {

struct Config {
  bool attitude = true;  ///< take the vertical and north from the AHRS when images have attitudes
  double stereo_matching_px = 0.3;  ///< 1 sigma of a disparity, for the sigma of the stereo scale
  double dead_reckoning_max_s = 5;  ///< beyond this the last velocity says nothing any more

  /// Between a map's plane and the mean viewing direction; the camera looks down, so a plane
  /// steeper than that is an artefact of a few images with doubtful calibration, or a wall, and
  /// gives no vertical.
  double max_plane_tilt_deg = 35;

  double altimeter_below_camera_m = 0;  ///< along the vehicle's down axis, from the lens
  std::string known_length;             ///< see parse_known_length; empty: none

  /// Of the ground where the first map's middle lies; see parse_origin; empty: unknown. With it the
  /// survey's y axis, if by the AHRS, is north of the UTM grid instead of true north.
  std::string origin;

  /// Throws InputError naming the setting, its value and the allowed range.
  void check() const;
};

/// Places the first sub-map at its own centroid, and every later one by attitude and dead reckoning
/// from what was last seen, marked uncertain. A pair of cameras gives the scale; else the most
/// certain of a known length, lasers, altimeter and changes of depth, also later on. Without them
/// the first map is sized so that the mean viewing distance of its tie points is 1, later ones so
/// that the distance to the seabed continues.
class SurveyFrame {
 public:
  /// The plane of a window in the window's own frame, or none.
  using PlaneOf = std::function<std::optional<Plane>(const Window&)>;

  /// lasers: none, or those beside the camera; a fault of theirs is told with the first shot.
  SurveyFrame(Config config, PlaneOf plane_of,
              const std::optional<calibration::Lasers>& lasers = std::nullopt,
              const AttitudeSigma& attitude_sigma = {});

  /// Before a shot is oriented: the same, or with the lasers' dots marked as hidden, or without
  /// its attitude once the AHRS was found to contradict the images. With an origin, its yaw is
  /// from then on the grid's, not from true north.
  std::shared_ptr<const Shot> mark(std::shared_ptr<const Shot> shot);

  /// initial: in the odometry frame of the new sub-map; frames: of initial.images, in their order.
  SubmapPlacement place(const Window& initial,
                        const std::vector<std::shared_ptr<const Frame>>& frames);

  /// Remembers the newest pose and viewing distance, from which a later sub-map is dead-reckoned,
  /// and measures the scale. Alerts when two sources of it disagree, and when the AHRS contradicts
  /// the images: by how it turns, or by a first map's ground that it calls a wall though a camera
  /// that is mounted to look down sees it from above.
  [[nodiscard]] std::vector<Alert> observe(const Orientation& orientation);

  /// After observe(): where the shot's image may have been taken when it has no pose; none before
  /// the first pose and for images without a frame.
  std::optional<DeadReckoned> dead_reckon(const Orientation& orientation) const;

  /// After observe(): the scale of the orientation's sub-map when it has become clearly better
  /// since it was last told; at the end, without a shot, those of all that were measured.
  std::vector<ScaleEstimate> improved_scales(const Orientation& orientation) {
    return claims_.improved(orientation);
  }

  /// Of the first sub-map; a later one's may be another, see SubmapPlacement. Doubtful once the
  /// AHRS that gave them was found to contradict the images.
  SurveyAxes axes() const {
    return attitude_doubtful_ && axes_ == SurveyAxes::attitude ? SurveyAxes::doubtful : axes_;
  }
  Scale scale() const { return scale_; }

 private:
  struct LastSeen {
    ImagePose pose;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< survey units per second
    std::optional<double> depth;  ///< of the vehicle below the surface, metres
    std::optional<Attitude> attitude;
  };
  struct Turn {
    Time time = 0;
    double yaw = 0;     ///< of the AHRS
    double turned = 0;  ///< since the last pose, about the survey frame's z
  };

  std::optional<Plane> plane_seen_from_above(const Window& initial) const;
  bool is_wall(const Eigen::Quaterniond& leveled, const std::optional<Plane>& plane,
               const Frame& first);
  Eigen::Quaterniond upright(const Window& initial, const std::optional<Plane>& plane) const;
  void leave_out_attitude();
  void tell_unplaced(const Orientation& orientation);
  void check_attitude(const Orientation& orientation);
  void follow_heading(const Frame& frame);
  double turned_by(Time time) const;
  Eigen::Vector3d reckoned_position(const Frame& frame) const;
  Eigen::Quaterniond reckoned_rotation(const Frame& frame) const;

  Config config_;
  PlaneOf plane_of_;
  std::optional<UtmGrid> grid_;    ///< with an origin
  bool unplaced_is_told_ = false;  ///< that the origin does not place the map
  SurveyAxes axes_ = SurveyAxes::none;
  Scale scale_;
  std::optional<LastSeen> last_;
  std::vector<Turn> turns_;  ///< of the images since last_, as long as they are reckoned on
  ScaleClaims claims_;
  AttitudeCheck attitude_check_;
  std::map<std::uint64_t, AttitudeSample> attitudes_;  ///< by image, of those without a pose yet
  bool attitude_doubtful_ = false;                     ///< the AHRS contradicts the images
  bool attitude_fails_ = false;                        ///< by its roll or pitch
  std::vector<Alert> alerts_;                          ///< to be told with the next orientation
  std::optional<calibration::Lasers> beams_;
  std::optional<Alert> lasers_alert_;  ///< to be told with the first shot
  double viewing_distance_ = 1;        ///< median over the last window, survey units
};

}  // namespace nadir::reference
