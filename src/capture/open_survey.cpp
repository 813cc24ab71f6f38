// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/folder_source.hpp"
#include "nadir/capture/video_source.hpp"

namespace nadir::capture {

std::unique_ptr<Source> open_survey(const std::filesystem::path& folder_or_video,
                                    const std::optional<std::filesystem::path>& calibration,
                                    const Config& config) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(folder_or_video, ignored))
    return std::make_unique<VideoSource>(folder_or_video, calibration, config);
  return std::make_unique<FolderSource>(folder_or_video, calibration, config);
}

}  // namespace nadir::capture
