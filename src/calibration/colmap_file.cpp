// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// https://colmap.github.io/cameras.html: CAMERA_ID MODEL WIDTH HEIGHT PARAMS, a line a camera. The
// centre of the first pixel is (0.5, 0.5).
#include <algorithm>
#include <sstream>
#include <string_view>

#include "camera_parts.hpp"
#include "formats.hpp"
#include "nadir/core/check.hpp"

namespace nadir::calibration {
namespace {

struct Model {
  std::string_view name;
  LensModel lens;
  std::vector<std::string> parameters;  ///< "f" is fx and fy
};

const std::vector<Model>& models() {
  constexpr LensModel kBrown = LensModel::brown_conrady, kFisheye = LensModel::kannala_brandt;
  static const std::vector<Model> list = {
      {"SIMPLE_PINHOLE", kBrown, {"f", "cx", "cy"}},
      {"PINHOLE", kBrown, {"fx", "fy", "cx", "cy"}},
      {"SIMPLE_RADIAL", kBrown, {"f", "cx", "cy", "k1"}},
      {"RADIAL", kBrown, {"f", "cx", "cy", "k1", "k2"}},
      {"OPENCV", kBrown, {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}},
      {"FULL_OPENCV",
       kBrown,
       {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
      {"SIMPLE_RADIAL_FISHEYE", kFisheye, {"f", "cx", "cy", "k1"}},
      {"RADIAL_FISHEYE", kFisheye, {"f", "cx", "cy", "k1", "k2"}},
      {"OPENCV_FISHEYE", kFisheye, {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"}},
  };
  return list;
}

struct Line {
  int number = 1;
  std::vector<std::string> words;
};

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines;
  std::istringstream stream(text);
  int number = 0;
  for (std::string row; std::getline(stream, row);) {
    ++number;
    std::istringstream words(row);
    Line line{number, {}};
    for (std::string word; words >> word;) line.words.push_back(std::move(word));
    if (!line.words.empty() && !line.words[0].starts_with('#')) lines.push_back(std::move(line));
    constexpr std::size_t kMostCameras = 10'000;  // one a photograph, of a large survey
    if (lines.size() > kMostCameras) break;
  }
  return lines;
}

bool is_number(const std::string& word) {
  return !word.empty() && word.find_first_not_of("0123456789") == word.npos;
}

// A line as keys and values, so that it is read and refused as all other formats are.
Field fields_of(const Line& line, const std::vector<std::string>& keys) {
  Field mapping;
  mapping.kind = Field::Kind::mapping;
  mapping.line = line.number;
  for (std::size_t i = 0; i < std::min(keys.size(), line.words.size()); ++i) {
    Field field;
    field.key = keys[i];
    field.text = line.words[i];
    field.line = line.number;
    mapping.items.push_back(std::move(field));
  }
  return mapping;
}

CameraModel read_camera(const Line& line, const std::string& name) {
  std::vector<std::string> keys = {"CAMERA_ID", "MODEL", "WIDTH", "HEIGHT"};
  const Field head = fields_of(line, keys);
  const Fields start(head, name);
  const std::string model_name = start.word("MODEL");
  const auto model = std::ranges::find(models(), model_name, &Model::name);
  if (model == models().end()) {
    start.fail("MODEL", '"' + model_name.substr(0, 40) + "\" is no lens model that nadir has",
               "run COLMAP with OPENCV or OPENCV_FISHEYE");
  }
  keys.insert(keys.end(), model->parameters.begin(), model->parameters.end());
  if (line.words.size() != keys.size()) {
    start.fail("MODEL",
               model_name + " takes " + std::to_string(model->parameters.size()) +
                   " parameters, there are " + std::to_string(std::ssize(line.words) - 4),
               "correct it");
  }
  const Field mapping = fields_of(line, keys);
  const Fields file(mapping, name);
  CameraModel camera;
  camera.lens = model->lens;
  read_size(file, "WIDTH", "HEIGHT", camera);
  camera.fx = file.number(file.has("f") ? "f" : "fx");
  camera.fy = file.number(file.has("f") ? "f" : "fy");
  camera.cx = file.number("cx") - 0.5;
  camera.cy = file.number("cy") - 0.5;
  const std::vector<const char*> names =
      model->lens == LensModel::kannala_brandt
          ? std::vector<const char*>{"k1", "k2", "k3", "k4"}
          : std::vector<const char*>{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    camera.distortion[i] = file.number_or_zero(names[i]);
  }
  check_camera(file, file.has("f") ? "f" : "fx", "k1", camera);
  return camera;
}

}  // namespace

bool is_colmap(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos || (text[first] != '#' && !is_number(text.substr(first, 1)))) return false;
  const std::vector<Line> lines = lines_of(text);
  if (lines.empty()) return text.find("CAMERA_ID, MODEL, WIDTH, HEIGHT") != text.npos;
  const std::vector<std::string>& words = lines.front().words;
  return words.size() >= 4 && is_number(words[0]) && is_number(words[2]) && is_number(words[3]) &&
         words[1].find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") == words[1].npos;
}

CameraRig read_colmap(const std::string& text, const std::string& name) {
  const std::vector<Line> lines = lines_of(text);
  if (lines.empty()) {
    throw InputError(name + ": CAMERA_ID: there is no camera; export the model again");
  }
  // COLMAP often has a camera per image or folder: alike, they are one.
  for (const Line& line : lines) {
    const bool alike = std::equal(line.words.begin() + 1, line.words.end(),
                                  lines[0].words.begin() + 1, lines[0].words.end());
    if (alike) continue;
    const Field mapping = fields_of(line, {"CAMERA_ID"});
    Fields(mapping, name)
        .fail("CAMERA_ID",
              "a second camera, unlike the first; which of them took the images is not known",
              "keep the line of that one");
  }
  CameraRig rig;
  rig.left = read_camera(lines.front(), name);
  return rig;
}

}  // namespace nadir::calibration
