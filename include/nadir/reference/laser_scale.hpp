// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Scale from two parallel lasers beside the camera, whose dots are seen on the seabed: their beams
// lie a known distance apart wherever they meet the ground.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nadir/calibration/lasers.hpp"
#include "nadir/core/frame.hpp"
#include "nadir/core/window.hpp"
#include "nadir/reference/scale_measure.hpp"

namespace nadir::reference {

/// Why these lasers give no scale, and the remedy; empty when they do. They must be two, with
/// origins_in_camera, about separation apart, and parallel: to direction_in_camera, else to the
/// optical axis.
std::string fault_of(const calibration::Lasers& lasers);

/// What their separation and their origins contradict each other in; the separation, which a ruler
/// gives, is then used. Empty when they agree.
std::string conflict_of(const calibration::Lasers& lasers);

/// Where a beam meets the seabed, as seen by the left camera.
struct LaserDot {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< x/z, y/z, undistorted
  double distance = 0;                            ///< from the laser along its beam, metres
  double radius_px = 0;                           ///< beyond this it does not show
};

struct LaserDots {
  std::uint64_t image = 0;
  std::array<LaserDot, 2> dots;  ///< in the order of origins_in_camera
};

/// The two dots in frame.colour, looked for where the beams meet ground 0.3 to 15 m away, to
/// 0.2 px per axis on gravel. None when either is not found, when they are at different distances,
/// or the image is grey. `lasers` must be without fault.
std::optional<LaserDots> find_laser_dots(const Frame& frame, const calibration::Lasers& lasers);

/// How far the ground is at the dots, with what their uncertainty makes of it.
std::vector<Range> ranges_of(const LaserDots& dots, const calibration::Lasers& lasers,
                             const CameraModel& camera);

struct LaserEstimate : ScaleMeasure {
  double sigma_of_image = 0;  ///< relative, of one image, from their spread
};

/// How large the map units of each sub-map are. In every image of a window the tie points around
/// a dot say how many map units away it is; two dots so placed are `separation` apart across the
/// beams. The estimate is a robust mean over a sub-map's images, each with its newest measure.
class LaserScale {
 public:
  /// lasers must be without fault.
  explicit LaserScale(const calibration::Lasers& lasers);

  /// To be told before the image is oriented. The last 4096 images are remembered.
  void observe(const LaserDots& dots);

  /// Measures the images of a window whose dots are known; for the window that starts a sub-map,
  /// which has no orientation yet. Its frame is free: the odometry's or the survey's.
  void observe(const Window& window);

  /// Measures the images new or moved, against the tie points of the sub-map's newest window.
  void observe(const Orientation& orientation);

  /// The map was multiplied by factor about any point, so its units have become smaller.
  void resized(std::uint32_t submap, double factor);

  /// None before three images of the sub-map were measured.
  std::optional<LaserEstimate> estimate(std::uint32_t submap) const;

 private:
  struct Ground {
    std::uint32_t submap = 0;
    std::vector<TiePoint> tie_points;
  };

  struct Measure {
    double log_ratio = 0;  ///< of metres per map unit
    double apart_px = 0;   ///< between the dots
  };

  void measure(const std::vector<ImagePose>& poses);

  calibration::Lasers lasers_;
  std::optional<Ground> ground_;                                        ///< of the newest window
  std::map<std::uint64_t, LaserDots> dots_;                             ///< by image
  std::map<std::uint32_t, std::map<std::uint64_t, Measure>> measures_;  ///< by sub-map and image
};

}  // namespace nadir::reference
