// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// https://colmap.github.io/format.html: two lines an image, IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID
// NAME with camera_from_map, and the image's points X Y POINT3D_ID ..., a line that may be empty.
#include <algorithm>
#include <array>
#include <map>

#include "file.hpp"
#include "nadir/capture/pose_files.hpp"
#include "nadir/core/check.hpp"
#include "pose_text.hpp"

namespace nadir::capture {
namespace {

namespace fs = std::filesystem;

struct NamedPose {
  Rigid3 map_from_camera;
  fs::path name;
  int line = 0;
};

NamedPose read_image(const PoseText& text) {
  const auto words = words_of(text.line(), 10);
  if (words.size() != 10) {
    text.fail("has " + std::to_string(words.size()) +
                  " values, expected 10: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
              "export the model again");
  }
  std::array<double, 7> v{};
  constexpr std::array kNames{"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = text.real(words[i + 1], kNames[i]);
  const Rigid3 camera_from_map = text.pose({v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6]});
  return {camera_from_map.inverse(), fs::path(words[9]), text.number()};
}

// Files made by hand often lack these lines; every second image would be taken for one.
void pass_points(PoseText& text) {
  if (!text.next()) return;
  const auto words = words_of(text.line());
  const auto is_number = [](std::string_view word) {
    return word.find_first_not_of("+-.0123456789eE") == word.npos;
  };
  if (words.size() % 3 == 0 && (words.empty() || is_number(words.back()))) return;
  text.fail("expected the points of the image in the line above, X Y POINT3D_ID ... or nothing",
            "export the model again, or add an empty line after each image's");
}

std::vector<NamedPose> read_images(const fs::path& file) {
  std::vector<NamedPose> poses;
  PoseText text(file);
  while (text.next()) {
    const auto first = text.line().find_first_not_of(" \t");
    if (first == std::string_view::npos || text.line()[first] == '#') continue;
    poses.push_back(read_image(text));
    pass_points(text);
  }
  if (poses.empty()) throw InputError(file.string() + ": has no image; export the model again");
  return poses;
}

std::string folder_of(const NamedPose& pose) { return pose.name.parent_path().filename().string(); }

fs::path images_file(const fs::path& model) {
  std::error_code error;
  if (!fs::is_directory(model, error)) {
    throw InputError(model.string() +
                     ": is not a folder; give the one of a COLMAP text model, with images.txt");
  }
  if (!fs::exists(model / "images.txt", error) && fs::exists(model / "images.bin", error)) {
    throw InputError(model.string() +
                     ": is a binary model; convert it with colmap model_converter --output_type "
                     "TXT, or export it as text");
  }
  return model / "images.txt";
}

}  // namespace

GivenPoses read_colmap_poses(const fs::path& model, const std::vector<ListedImage>& images) {
  const fs::path file = images_file(model);
  std::vector<NamedPose> poses = read_images(file);
  const bool pairs =
      std::ranges::any_of(poses, [](const auto& p) { return folder_of(p) == "left"; });
  if (pairs) std::erase_if(poses, [](const auto& p) { return folder_of(p) == "right"; });
  std::map<std::string, const NamedPose*> by_stem;
  for (const NamedPose& pose : poses) {
    const std::string stem = printable(pose.name.stem().string());
    const auto [known, fresh] = by_stem.emplace(stem, &pose);
    if (fresh) continue;
    throw InputError(file.string() + ':' + std::to_string(pose.line) + ": is named " + stem +
                     " as line " + std::to_string(known->second->line) +
                     "; keep the one of the images to be mapped");
  }
  GivenPoses given{model.string(), {}, false, false};
  bool any = false;
  for (const ListedImage& image : images) {
    const auto found = by_stem.find(image.name);
    auto& pose = given.map_from_camera.emplace_back();
    if (found == by_stem.end()) continue;
    pose = found->second->map_from_camera;
    any = true;
  }
  if (!any) {
    throw InputError(file.string() + ": has none of the images: its first is " +
                     printable(poses.front().name.string()) + ", theirs " +
                     (images.empty() ? std::string("unknown") : images.front().name) +
                     "; give the model of these images");
  }
  return given;
}

}  // namespace nadir::capture
