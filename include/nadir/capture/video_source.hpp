// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images from a video file, decoded by an ffmpeg of its own process: what a damaged video does to
// the decoder stays there.
#pragma once

#include "nadir/capture/source.hpp"

namespace nadir::capture {

/// Any format that ffmpeg knows; one camera. An image's time is the video's own from its beginning,
/// and of those logs beside it (ahrs.csv, depth.csv, altitude.csv) that go by it. calib.yml and
/// lasers.yml are taken from beside it, too. The picture is never rotated or cropped.
class VideoSource : public Source {
 public:
  /// calibration: instead of calib.yml beside the video. Throws InputError naming file, fault and
  /// remedy when ffmpeg is not installed, the file is no video, holds no image or is of another
  /// size than the calibration, or a file beside it is malformed.
  VideoSource(const std::filesystem::path& video,
              const std::optional<std::filesystem::path>& calibration, const Config& config);
  ~VideoSource() override;

  /// With the last one, whether ffmpeg came to the video's end.
  std::optional<Shot> next() override;
  std::size_t size() const override;
  std::vector<ListedImage> images() const override { return {}; }
  std::shared_ptr<const CameraRig> rig() const override;
  bool is_stereo() const override { return false; }
  const std::optional<calibration::Lasers>& lasers() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::capture
