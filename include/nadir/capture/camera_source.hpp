// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images from cameras as they are taken.
#pragma once

#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "nadir/capture/source.hpp"

namespace nadir::capture {

/// One camera, or two as a pair. Config::camera and camera_right name them: a path of
/// /dev/v4l/by-path or by-id; the serial number, the bus or the card that VIDIOC_QUERYCAP tells, if
/// just one camera has it; "auto", the only USB camera; or "libcamera:ID" for a camera of
/// libcamera, by its id or the end of it, and "libcamera:auto" for the only one.
class CameraSource {
 public:
  /// keep_originals: shots carry the images as they came. Opens no camera yet. Throws InputError
  /// when the calibration is missing, malformed or not of as many cameras.
  explicit CameraSource(const Config& config, bool keep_originals = false);
  ~CameraSource();

  /// Waits for the next image or pair, a second at most; none once told to stop. Cameras that are
  /// not there, fail or fall silent are opened again and again, told by camera_lost and
  /// camera_back. Times are CLOCK_MONOTONIC's and increase. Images that a camera or its cable lost
  /// or damaged are counted in Shot::missed_before and told.
  std::optional<Captured> next(const std::stop_token& stop);

  /// The next image is number 0: another dive's first.
  void count_anew();

  /// At the processed scale; has a right camera only for a pair.
  std::shared_ptr<const CameraRig> rig() const;
  const std::optional<calibration::Lasers>& lasers() const;
  /// How fast the ground moves in the images at the processed scale, px a second, 0: unknown; for
  /// the exposure. Any thread.
  void note_speed(double px_a_second);
  /// As the cameras are set; none where that is not known. Any thread.
  std::optional<double> exposure_ms() const;
  /// Right minus left time of a pair's pictures, the median of the last twenty; none before.
  /// Any thread.
  std::optional<Time> skew() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Names and contents of the files that a survey folder of this camera needs: calib.yml, and
/// lasers.yml if there is one.
std::vector<std::pair<std::string, std::string>> calibration_files(const Config& config);

}  // namespace nadir::capture
