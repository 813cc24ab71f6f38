// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/calibration/rig_file.hpp"

#include "formats.hpp"
#include "nadir/core/check.hpp"
#include "text_file.hpp"

namespace nadir::calibration {
namespace {

struct Format {
  bool (*recognised)(const Fields&);
  CameraRig (*read)(const Fields&);
};

// OpenCV's, which needs no mark of its own, comes last.
constexpr Format kYamlFormats[] = {
    {is_kalibr, read_kalibr},   {is_orb_slam, read_orb_slam},
    {is_matisse, read_matisse}, {is_ros_camera_info, read_ros_camera_info},
    {is_okvis, read_okvis},
};

constexpr const char* kExpected =
    "the calibration of a camera: YAML by OpenCV, ROS, Kalibr, OKVIS, ORB-SLAM or Matisse, XML by "
    "OpenCV or Metashape, or COLMAP's cameras.txt";

// These files look like OpenCV's, but for one key.
void refuse_other_models(const Fields& file) {
  constexpr std::pair<const char*, const char*> kMarks[] = {
      {"xi", "the unified (omnidirectional, Mei) or double sphere"},
      {"alpha", "the extended unified (EUCM) or double sphere"}};
  for (const auto& [key, model] : kMarks) {
    if (!file.has(key)) continue;
    file.fail(key, std::string("belongs to ") + model + " model, which nadir does not have",
              "calibrate as brown_conrady or kannala_brandt");
  }
}

// JSON is a kind of YAML: it is not read, but a better reason may be found in it.
void refuse_other_models_in_json(const std::string& text, const std::string& file) {
  if (!text.starts_with('{')) return;
  Field root;
  try {
    root = parse_yaml(text);
  } catch (const InputError&) {
    return;
  }
  refuse_other_models(Fields(root, file));
}

CameraRig read_xml(const Fields& file) {
  if (is_metashape(file)) return read_metashape(file);
  file.require_opencv();
  refuse_other_models(file);
  return read_opencv(file);
}

}  // namespace

CameraRig load_rig(const std::filesystem::path& path) {
  const std::string text = read_text(path), name = path.string();
  if (is_colmap(text)) return read_colmap(text, name);
  refuse_other_models_in_json(text, name);
  const Field root = parse_fields(text, name, kExpected);
  const Fields file(root, name);
  if (!file.name().empty()) return read_xml(file);
  refuse_other_models(file);
  if (file.has("camera_matrix")) return read_opencv(file);  // whatever else stands beside it
  for (const Format& format : kYamlFormats) {
    if (format.recognised(file)) return format.read(file);
  }
  return read_opencv(file);
}

}  // namespace nadir::calibration
