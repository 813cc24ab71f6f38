// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images from a survey folder, in order, each with its time and what the sensors said then
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

  /// Throws InputError for any other scale, or an angle beyond 180 degrees.
  void check() const;
  Eigen::Quaterniond body_from_camera() const;
  int divisor() const { return static_cast<int>(1 / scale); }
};

/// An image, or the left one of a pair, as the folder lists it.
struct ListedImage {
  std::string name;  ///< of its file, without extension
  std::optional<Time> time;
};

/// FOLDER/images/left and right, FOLDER/images, or FOLDER itself; JPEG, PNG and TIFF files in the
/// natural order of their names, pairs matched by name without extension.
/// Times: timestamps.csv; else EXIF, when all images have it and it always increases; else 1 Hz
/// from 0. ahrs.csv, depth.csv and altitude.csv are interpolated over gaps of at most 0.5 s.
class FolderSource {
 public:
  /// calibration: instead of FOLDER/calib.yml. Throws InputError naming file, fault and remedy when
  /// there is no image, no image fits the calibration, or a file beside the images is malformed.
  FolderSource(const std::filesystem::path& folder,
               const std::optional<std::filesystem::path>& calibration, const Config& config);
  ~FolderSource();
  FolderSource(FolderSource&&) noexcept;
  FolderSource& operator=(FolderSource&&) noexcept;

  /// The next image or pair; none at the end. What cannot be used, a damaged or wrongly sized file,
  /// an image without its partner or without a time later than the ones before, is a shot without a
  /// frame and with an image_rejected alert. Times of shots never decrease, those of frames
  /// increase.
  std::optional<Shot> next();

  /// Images or pairs listed, those to be rejected included.
  std::size_t size() const;
  /// All of them, by image number.
  std::vector<ListedImage> images() const;
  /// At the processed scale; has a right camera only when is_stereo().
  std::shared_ptr<const CameraRig> rig() const;
  bool is_stereo() const;
  bool has_attitude() const;  ///< there is an ahrs.csv
  const std::optional<calibration::Lasers>& lasers() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::capture
