// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What images and sensors tell of the vehicle's motion over the ground, for a diver's dials.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "board.hpp"
#include "config.hpp"
#include "image_speed.hpp"
#include "nadir/core/revision.hpp"
#include "nadir/coverage/polygon.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::app {

/// Altitude is the median depth of the tie points in view, along the optical axis; speed the way
/// over ground of the last second; overlap that of the newest two images with a pose, on a plane at
/// that depth across the optical axis.
class Gauges {
 public:
  explicit Gauges(const Config& config);

  void observe(const Orientation& orientation);

  /// What else limits the values.
  struct Limits {
    double usual_width = 0;   ///< of a footprint, survey units as odometry left them; 0: unknown
    double lane_spacing = 0;  ///< survey units as corrected; 0: no lanes
    bool metric = false;
    double convergence = 0;  ///< from true north to survey y, clockwise
  };
  /// As of the newest image.
  wire::Measures measures(const Corrections& corrections, const Board& board,
                          const Limits& limits) const;

  /// Of the newest image with a pose, as odometry left it; null before.
  const ImagePose* newest() const { return poses_.empty() ? nullptr : &poses_.rbegin()->second; }
  /// Of the last second, as odometry left it; none where tracking gives none.
  std::optional<Eigen::Vector3d> velocity() const;

 private:
  using Limited = wire::Measures::Measure;

  bool is_tracked() const;
  const ImagePose* before_newest() const;
  std::optional<double> depth_in_view() const;
  double overlap(const Rigid3& newest_from_before, double depth) const;
  std::optional<double> fastest(double depth) const;
  std::optional<double> period_s() const;
  void add_motion(const Corrections& corrections, const Limits& limits,
                  wire::Measures& measures) const;
  void add_picture(const Board& board, wire::Measures& measures) const;
  Limited limited_altitude(double altitude, double size, const Limits& limits) const;

  const GuideConfig config_;
  const odometry::Config weak_;
  const double max_blur_px_;
  const int divisor_;  ///< of the processed scale
  ImageSpeed image_speed_;
  std::optional<double> speed_px_;            ///< a second, at the processed scale
  std::map<std::uint64_t, ImagePose> poses_;  ///< of late
  std::shared_ptr<const Window> window_;
  std::shared_ptr<const CameraRig> rig_;
  coverage::Polygon view_;  ///< the image's corners, x/z and y/z
  // Of the newest image.
  std::optional<std::uint64_t> image_;
  Time time_ = 0;
  std::optional<Attitude> attitude_;
  std::optional<double> depth_;
  Health health_;
};

}  // namespace nadir::app
