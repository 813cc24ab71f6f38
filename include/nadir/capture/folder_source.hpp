// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images from a survey folder.
#pragma once

#include "nadir/capture/source.hpp"

namespace nadir::capture {

/// FOLDER/images/left and right, FOLDER/images, or FOLDER itself; JPEG, PNG and TIFF files in the
/// natural order of their names, pairs matched by name without extension.
/// Times: timestamps.csv; else EXIF, when all images have it and it always increases; else 1 Hz
/// from 0. ahrs.csv, depth.csv and altitude.csv are interpolated over gaps of at most 0.5 s.
class FolderSource : public Source {
 public:
  /// calibration: instead of FOLDER/calib.yml. Throws InputError naming file, fault and remedy when
  /// there is no image, no image fits the calibration, or a file beside the images is malformed.
  FolderSource(const std::filesystem::path& folder,
               const std::optional<std::filesystem::path>& calibration, const Config& config);
  ~FolderSource() override;

  std::optional<Shot> next() override;
  std::size_t size() const override;
  std::vector<ListedImage> images() const override;
  std::shared_ptr<const CameraRig> rig() const override;
  bool is_stereo() const override;
  const std::optional<calibration::Lasers>& lasers() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::capture
