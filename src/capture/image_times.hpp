// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// When each image was taken.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "image_list.hpp"
#include "nadir/core/time.hpp"

namespace nadir::capture {

struct ImageTime {
  Time time = 0;      ///< with a fault: of the last image before that has none
  std::string fault;  ///< why the image cannot be used
};

/// One per image: from timestamps.csv, else EXIF, else 1 Hz from 0. Images whose time does not
/// increase are faults, as few of them as possible. Throws InputError for a malformed
/// timestamps.csv or one that knows none of the images.
std::vector<ImageTime> image_times(const std::filesystem::path& survey_folder,
                                   const ImageList& list);

}  // namespace nadir::capture
