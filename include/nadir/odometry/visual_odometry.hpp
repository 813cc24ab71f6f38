// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Visual odometry with windowed bundle adjustment (paper 3.2), mono and stereo.
// Images in input order go in; poses, lost images and adjusted windows of key frames come out.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "nadir/core/window.hpp"

namespace nadir::odometry {

enum class OnLost {
  stop,    ///< the paper's behaviour: nothing after the loss is oriented
  submap,  ///< look for the recent ground, else start a new sub-map at the image that failed
};

struct Config {
  int initial_images = 5;         ///< key images that start the map of a single camera; others: 3
  int window = 5;                 ///< key frames adjusted together, 3 or more (paper: 3 or 5)
  int features = 1500;            ///< corners described per image
  int tie_points = 400;           ///< wanted per key frame
  double key_frame_shift = 0.10;  ///< image motion that makes a key frame, of the shorter side
  double min_parallax_deg = 1.2;  ///< intersection angle a new tie point needs
  double attitude_sigma_deg = 2;  ///< of the AHRS's roll and pitch, mounting included; 0: not used
  double heading_sigma_deg = 5;   ///< of its heading beside a slowly varying offset; 0: not used
  double depth_sigma_m = 0.05;    ///< of the depth sensor beside such an offset; 0: not used
  double range_sigma = 0.02;  ///< of a laser's range beside one, relative, ground between included;
                              ///< 0: not used
  int relocalise_key_frames = 6;  ///< recent key frames searched after a loss
  OnLost on_lost = OnLost::submap;

  // An image beyond one of these is weak: health.csv says so.
  int weak_tie_points = 40;    ///< fewer
  int weak_quadrant = 3;       ///< fewer tie points in a quadrant
  int weak_track_length = 3;   ///< seen in fewer images, in the median
  double weak_rms_px = 1.2;    ///< larger
  double weak_sharpness = 20;  ///< less, variance of the Laplacian
  double weak_dark = 25;       ///< darker, mean grey level
  double weak_bright = 230;    ///< brighter

  /// Throws InputError naming the key, its value and the allowed range.
  void check() const;
};

/// Places a fresh sub-map: its initial window in the `odometry` frame (first camera at the origin;
/// metric when stereo, else at arbitrary scale) with the frames of window.images.
using Placement = std::function<SubmapPlacement(
    const Window& initial, const std::vector<std::shared_ptr<const Frame>>& frames)>;

class VisualOdometry {
 public:
  VisualOdometry(Config config, Placement placement);
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;
  ~VisualOdometry();

  /// Exactly one Orientation per Shot, in order. A Shot without frame (a rejected image) changes
  /// nothing. Every captured frame ends exactly once: in Orientation::poses or Orientation::lost.
  Orientation process(std::shared_ptr<const Shot> shot);

  /// The next map is started anew, whatever the images show of the present one: for a diver who
  /// doubts it.
  void begin_submap();

  /// After the last shot: what was still waited for. Orientation::shot is null.
  Orientation finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::odometry
