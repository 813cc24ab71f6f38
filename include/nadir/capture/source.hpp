// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where images come from, one after the other, each with its time and what the sensors said then
// (paper 3.1, 4).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nadir/calibration/lasers.hpp"
#include "nadir/core/frame.hpp"

namespace nadir::capture {

struct Config {
  double scale = 1;  ///< processed size per side: 1, 0.5 or 0.25

  // The camera in the vehicle, turned from looking down with the image's top forward: Tait-Bryan
  // Z-Y-X about the body's axes (FRD).
  double mounting_roll_deg = 0;   ///< right side down
  double mounting_pitch_deg = 0;  ///< a camera that looks ahead by 30 degrees has +30
  double mounting_yaw_deg = 0;    ///< clockwise seen from above

  double rate_hz = 10;  ///< images a second taken from a video or a camera; 0: all

  // Live cameras.
  std::string camera = "auto";  ///< of a pair the left one; "auto", or as CameraSource says
  std::string camera_right{};   ///< empty: a single camera
  std::string calibration = "/etc/nadir/camera.yml";  ///< lasers.yml lies beside it
  double exposure_ms = 0;                             ///< 0: steered by light and speed
  double gain = -1;                                   ///< in the camera's unit; -1: likewise
  double focus = -1;       ///< in the camera's unit; -1: as it is. It never focuses by itself
  double max_blur_px = 1;  ///< full-size pixels that motion may smear; exposures keep to it
  double max_skew_ms = 2;  ///< between the pictures of a pair, before it is told

  /// Throws InputError naming the setting that is out of range.
  void check() const;
  Eigen::Quaterniond body_from_camera() const;
  int divisor() const { return static_cast<int>(1 / scale); }
};

/// An image, or the left one of a pair.
struct ListedImage {
  std::string name;  ///< of its file, without extension
  std::optional<Time> time;
};

/// What came of waiting for a camera.
struct Captured {
  std::optional<Shot> shot;
  std::vector<Alert> alerts;  ///< that belong to no image
};

class Source {
 public:
  Source() = default;
  virtual ~Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /// The next image or pair; none at the end. What cannot be used, a damaged or wrongly sized file,
  /// an image without its partner or without a time later than the ones before, is a shot without a
  /// frame and with an image_rejected alert. Times of shots never decrease, those of frames
  /// increase.
  virtual std::optional<Shot> next() = 0;

  /// Images or pairs there are, those to be rejected included; about so many in a video.
  virtual std::size_t size() const = 0;
  /// All of them, by image number; empty when they are not known beforehand.
  virtual std::vector<ListedImage> images() const = 0;
  /// At the processed scale; has a right camera only when is_stereo().
  virtual std::shared_ptr<const CameraRig> rig() const = 0;
  virtual bool is_stereo() const = 0;
  virtual const std::optional<calibration::Lasers>& lasers() const = 0;
};

/// A survey folder of images (FolderSource), or a video file (VideoSource). calibration: instead of
/// calib.yml in the folder, or beside the video. Throws InputError naming file, fault and remedy.
std::unique_ptr<Source> open_survey(const std::filesystem::path& folder_or_video,
                                    const std::optional<std::filesystem::path>& calibration,
                                    const Config& config);

}  // namespace nadir::capture
