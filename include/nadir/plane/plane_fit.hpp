// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The plane of a window's tie points, accepted or refused with the reason (paper 3.3).
#pragma once

#include <optional>
#include <span>
#include <string>

#include "nadir/core/surface.hpp"

namespace nadir::plane {

/// Distances are ratios of the viewing distance (median of the points' distances to the central
/// camera), so that unscaled maps are judged as scaled ones are.
struct Config {
  int min_images = 2;              ///< a tie point counts when seen in at least so many images
  double max_reprojection_px = 3;  ///< and reprojected with at most this RMS
  double inlier_distance = 0.05;   ///< of the viewing distance
  double min_inlier_ratio = 0.4;   ///< below it the seabed is not planar
  double max_tilt_deg = 70;        ///< between the plane's normal and the central optical axis
  int max_iterations = 1000;       ///< RANSAC samples at most

  /// Throws InputError naming the setting, its range and the remedy.
  void check() const;
};

/// A plane, or one line that says why there is none.
struct Fit {
  std::optional<Plane> plane;
  std::string why_not;
};

/// RANSAC plane of tie points seen from images, refined by iterated robust least squares; its
/// normal points towards the cameras. Points and poses share one frame, of any scale, and so does
/// the plane. The central view is images[size / 2]. Deterministic. Points that are not finite or
/// weakly observed are left out; no plane for fewer than three, for collinear or coincident points,
/// for a plane that a camera lies behind or that the central view sees edge-on.
Fit fit_plane(std::span<const TiePoint> tie_points, std::span<const ImagePose> images,
              const Config& config);

/// Fits every window and tells the diver once when the seabed stops being planar: the alert rests
/// until several windows in a row had a plane again.
class PlaneFit {
 public:
  explicit PlaneFit(const Config& config) : config_(config) {}
  /// One surface per orientation, in order; without a window just the source.
  Surface process(std::shared_ptr<const Orientation> orientation);

 private:
  void watch(Surface& surface);

  Config config_;
  int planes_in_a_row_ = 0;
  bool warned_ = false;
};

}  // namespace nadir::plane
