// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// ORB-SLAM's settings: flat keys, "Camera.fx", since ORB-SLAM3 1.0 also "Camera1.fx". Pixels as
// OpenCV's.
#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

// What of a stereo file's keys belongs to the images as stored is not certain: fx may be of the
// rectified ones.
void refuse_stereo(const Fields& file) {
  for (const char* prefix : {"Camera2.", "LEFT.", "RIGHT.", "Stereo."}) {
    const std::string key = file.key_starting_with(prefix);
    if (key.empty()) continue;
    file.fail(key, "is of a stereo camera, which is not read from ORB-SLAM's settings",
              "write the pair as OpenCV YAML or a Kalibr camchain");
  }
}

LensModel lens(const Fields& file) {
  if (!file.has("Camera.type")) return LensModel::brown_conrady;  // ORB-SLAM2 knew only one
  const std::string type = file.word("Camera.type");
  if (type == "PinHole" || type == "Rectified") return LensModel::brown_conrady;
  if (type == "KannalaBrandt8") return LensModel::kannala_brandt;
  file.fail("Camera.type", '"' + type.substr(0, 40) + "\" is neither PinHole nor KannalaBrandt8",
            "calibrate with one of the two");
}

}  // namespace

bool is_orb_slam(const Fields& file) {
  return file.has("Camera.fx") || file.has("Camera1.fx") || file.has("Camera.type");
}

CameraRig read_orb_slam(const Fields& file) {
  refuse_stereo(file);
  const std::string prefix = file.has("Camera1.fx") ? "Camera1." : "Camera.";
  CameraModel camera;
  camera.lens = lens(file);
  read_size(file, "Camera.width", "Camera.height", camera);
  camera.fx = file.number(prefix + "fx");
  camera.fy = file.number(prefix + "fy");
  camera.cx = file.number(prefix + "cx");
  camera.cy = file.number(prefix + "cy");
  if (camera.lens == LensModel::kannala_brandt) {
    for (int i = 0; i < 4; ++i) {
      camera.distortion[static_cast<std::size_t>(i)] =
          file.number(prefix + "k" + std::to_string(i + 1));
    }
  } else {  // ORB-SLAM3 takes what is absent as zero
    const char* const kNames[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    for (std::size_t i = 0; i < 8; ++i) {
      camera.distortion[i] = file.number_or_zero(prefix + kNames[i]);
    }
  }
  check_camera(file, prefix + "fx", prefix + "k1", camera);
  CameraRig rig;
  rig.left = camera;
  return rig;
}

}  // namespace nadir::calibration
