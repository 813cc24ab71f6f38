// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_list.hpp"

#include <algorithm>
#include <map>

#include "nadir/core/check.hpp"

namespace nadir::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDigits = "0123456789";

std::string_view take(std::string_view& text, std::size_t length) {
  const std::string_view head = text.substr(0, length);
  text.remove_prefix(head.size());
  return head;
}

// Negative, zero or positive, as std::string_view::compare.
int compare_numbers(std::string_view a, std::string_view b) {
  a.remove_prefix(std::min(a.find_first_not_of('0'), a.size()));
  b.remove_prefix(std::min(b.find_first_not_of('0'), b.size()));
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  return a.compare(b);
}

std::string stem_of(const std::string& name) { return name.substr(0, name.rfind('.')); }

bool is_image_name(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos || dot == 0 || name[0] == '.') return false;
  std::string extension = name.substr(dot + 1);
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension == "jpg" || extension == "jpeg" || extension == "png" || extension == "tif" ||
         extension == "tiff";
}

std::vector<std::string> image_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code unknown;
    std::string name = at->path().filename().string();
    const bool folder_or_link_to_one = at->is_directory(unknown);
    if (is_image_name(name) && !folder_or_link_to_one) names.push_back(std::move(name));
  }
  if (error) throw InputError(folder.string() + ": cannot be listed: " + error.message());
  std::sort(names.begin(), names.end(), natural_less);
  return names;
}

std::vector<ImageFiles> pair_by_name(std::vector<std::string> left,
                                     std::vector<std::string> right) {
  std::map<std::string, std::string> right_by_stem;
  for (std::string& name : right) right_by_stem.emplace(stem_of(name), name);
  std::vector<ImageFiles> pairs;
  for (std::string& name : left) {
    const auto match = right_by_stem.extract(stem_of(name));
    pairs.push_back({std::move(name), match ? match.mapped() : std::string()});
  }
  for (auto& [stem, name] : right_by_stem) pairs.push_back({{}, std::move(name)});
  const auto name_of = [](const ImageFiles& pair) -> const std::string& {
    return pair.left.empty() ? pair.right : pair.left;
  };
  std::sort(pairs.begin(), pairs.end(), [&](const ImageFiles& a, const ImageFiles& b) {
    return natural_less(name_of(a), name_of(b));
  });
  return pairs;
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    const std::string_view text_a = take(a, a.find_first_of(kDigits));
    const std::string_view text_b = take(b, b.find_first_of(kDigits));
    if (const int order = text_a.compare(text_b); order != 0) return order < 0;
    if (a.empty() || b.empty()) break;
    const std::string_view number_a = take(a, a.find_first_not_of(kDigits));
    const std::string_view number_b = take(b, b.find_first_not_of(kDigits));
    if (const int order = compare_numbers(number_a, number_b); order != 0) return order < 0;
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // 01 and 1
}

std::string ImageList::stem(std::size_t image) const {
  const ImageFiles& files = images[image];
  return stem_of(files.left.empty() ? files.right : files.left);
}

ImageList list_images(const fs::path& survey_folder) {
  std::error_code ignored;
  if (!fs::is_directory(survey_folder, ignored)) {
    throw InputError(survey_folder.string() +
                     ": is not a folder that can be read; check its name and permissions");
  }
  const fs::path images = survey_folder / "images";
  ImageList list;
  list.left_folder = survey_folder;
  if (fs::is_directory(images, ignored)) list.left_folder = images;
  if (fs::is_directory(images / "left", ignored)) list.left_folder = images / "left";
  if (fs::is_directory(images / "left", ignored) && fs::is_directory(images / "right", ignored)) {
    list.right_folder = images / "right";
    list.images = pair_by_name(image_names(list.left_folder), image_names(list.right_folder));
  } else {
    for (std::string& name : image_names(list.left_folder)) {
      list.images.push_back({std::move(name), {}});
    }
  }
  if (list.images.empty()) {
    throw InputError(list.left_folder.string() +
                     ": holds no JPEG, PNG or TIFF image; give a folder of images, or one that has "
                     "them in images/, or in images/left and images/right");
  }
  return list;
}

}  // namespace nadir::capture
