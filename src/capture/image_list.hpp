// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which images a survey folder holds, and their natural order.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nadir::capture {

/// Runs of digits compare as numbers, the text between them bytewise: img2 before img10.
bool natural_less(std::string_view a, std::string_view b);

/// File names of one image or pair; a missing one is empty.
struct ImageFiles {
  std::string left, right;
};

struct ImageList {
  std::filesystem::path left_folder, right_folder;  ///< right empty when mono
  std::vector<ImageFiles> images;

  bool is_stereo() const { return !right_folder.empty(); }
  /// Name without extension, of the left image where there is one.
  std::string stem(std::size_t image) const;
};

/// Throws InputError when there is no folder or no image in it.
ImageList list_images(const std::filesystem::path& survey_folder);

}  // namespace nadir::capture
