// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What odometry finds for one image, and the window of key frames it adjusted.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nadir/core/frame.hpp"
#include "nadir/core/rigid3.hpp"

namespace nadir {

enum class TrackingState { waiting, initialising, tracking, lost };
std::string_view to_string(TrackingState state);

enum class ScaleSource {
  none,
  stereo,
  laser,
  typed,
  altitude,
  depth,
  poses,  ///< that of poses given by another program
};
std::string_view to_string(ScaleSource source);
/// As a diver reads it: the lasers.
std::string_view in_words(ScaleSource source);

/// What gave the survey frame its axes.
enum class SurveyAxes : std::uint8_t {
  none,          ///< no map yet
  first_plane,   ///< z along the first map's plane normal, x the first camera's x axis projected on
                 ///< it
  attitude,      ///< x east, y north, z up, from the AHRS
  first_camera,  ///< no plane either: z against the mean viewing direction
  poses,         ///< those of poses given by another program
  doubtful,      ///< by an AHRS that the images contradicted later on: north, and up where its roll
                 ///< or pitch do, are not to be relied on
};
std::string_view to_string(SurveyAxes axes);

struct Scale {
  ScaleSource source = ScaleSource::none;
  double sigma = 0;  ///< relative, 1 sigma; 0 when unscaled or unknown
};

/// Exterior orientation of one image.
struct ImagePose {
  std::uint64_t image = 0;
  Time time = 0;
  std::uint32_t submap = 0;
  Rigid3 survey_from_camera;
  bool key_frame = false;
  std::uint32_t tie_points = 0;  ///< observed in this image
  double rms_px = 0;             ///< of their reprojection
  // 1 sigma relative to the key frame before it, or of images between key frames against the map as
  // it is; 0: unknown. Roots of the sums of three variances.
  double sigma_position = 0;  ///< survey units
  double sigma_rotation = 0;  ///< radians
};

struct TiePoint {
  std::uint64_t id = 0;  ///< unique in the dive
  Eigen::Vector3d x_in_survey = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> rgb{};
  std::uint32_t images = 0;  ///< in how many it was observed
  double rms_px = 0;
};

/// The last n key frames after their bundle adjustment (paper 3.2).
struct Window {
  std::uint32_t submap = 0;
  std::vector<ImagePose> images;  ///< n, oldest first
  std::vector<TiePoint> tie_points;
  std::vector<std::uint64_t> given_up;   ///< ids of earlier tie points that proved wrong
  std::shared_ptr<const Frame> central;  ///< frame of images[n / 2]
  Scale scale;
  SurveyAxes axes = SurveyAxes::none;
  bool uncertain = false;  ///< the sub-map was placed by attitude and dead reckoning only
  double rms_px = 0;
  int iterations = 0;
  bool converged = false;

  const ImagePose& central_pose() const { return images[images.size() / 2]; }
};

/// What makes an image weak for mapping, by the thresholds of the configuration.
enum class Weakness : std::uint8_t {
  few_tie_points,
  one_sided,  ///< a quadrant has next to no tie points
  short_tracks,
  large_residuals,
  blurred,
  dark,
  bright
};
inline constexpr std::array kWeaknesses{Weakness::few_tie_points, Weakness::one_sided,
                                        Weakness::short_tracks,   Weakness::large_residuals,
                                        Weakness::blurred,        Weakness::dark,
                                        Weakness::bright};
std::string_view to_string(Weakness weakness);

/// Per image, for health.csv.
struct Health {
  std::uint32_t tie_points = 0;
  std::array<std::uint32_t, 4> by_quadrant{};  ///< top left, top right, bottom left, bottom right
  double tracked_length = 0;  ///< median number of images a tie point was seen in, this one too
  double rms_px = 0;
  double sharpness = 0;         ///< variance of the Laplacian, grey levels squared
  double exposure = 0;          ///< mean grey level, 0 to 255
  std::uint8_t weaknesses = 0;  ///< bit by bit; of images without a pose, of the picture alone

  void add(Weakness weakness) {
    weaknesses = static_cast<std::uint8_t>(weaknesses | 1U << static_cast<unsigned>(weakness));
  }
  bool has(Weakness weakness) const {
    return (weaknesses >> static_cast<unsigned>(weakness) & 1U) != 0;
  }
};

struct ImageHealth {
  std::uint64_t image = 0;
  Health health;
};

/// Where an image without a pose may have been taken: by the vehicle's last motion, the attitude
/// and the depth.
struct DeadReckoned {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;  ///< from whose last pose it was reckoned
  Rigid3 survey_from_camera;
  double sigma_position = 0;  ///< survey units, of each coordinate
};

struct SettledKeyFrame;

/// Everything odometry has to say after one shot; exactly one per shot, in order.
struct Orientation {
  std::shared_ptr<const Shot> shot;
  TrackingState state = TrackingState::waiting;
  std::uint32_t submap = 0;
  /// Poses that are new or were changed by this shot: its own, those of the initial images once the
  /// map starts, those the window adjustment moved.
  std::vector<ImagePose> poses;
  /// Images given up by this shot: waited for in initialisation or tracked without success.
  std::vector<std::uint64_t> lost;
  std::optional<DeadReckoned> dead_reckoned;  ///< the shot's own image while it has no pose
  std::shared_ptr<const Window> window;       ///< null when no window was completed by this shot
  SurveyAxes axes = SurveyAxes::none;         ///< of the survey as far as known; none: as of window
  /// Key frames that odometry will not change any more, each once, in order.
  std::vector<std::shared_ptr<const SettledKeyFrame>> settled;
  Health health;
  std::vector<ImageHealth> later_health;  ///< of earlier images, known only with this shot
  std::vector<Alert> alerts;
};

/// How a fresh sub-map came to be placed in the survey frame.
struct SubmapPlacement {
  Similarity3 survey_from_odometry;
  Scale scale;
  SurveyAxes axes = SurveyAxes::none;
  bool uncertain = false;  ///< placed by attitude and dead reckoning only
};

}  // namespace nadir
