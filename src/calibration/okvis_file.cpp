// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// OKVIS: a list `cameras`, T_SC from camera to sensor (the IMU), metres. Pixels as OpenCV's.
#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

void read_pinhole(const Fields& file, CameraModel& camera) {
  const std::vector<double> focal = file.numbers("focal_length", 2);
  const std::vector<double> centre = file.numbers("principal_point", 2);
  camera.fx = focal[0];
  camera.fy = focal[1];
  camera.cx = centre[0];
  camera.cy = centre[1];
}

CameraModel read_camera(const Fields& file) {
  CameraModel camera;
  read_size(file, "image_dimension", camera);
  camera.lens = read_lens(file, "distortion_type");
  read_pinhole(file, camera);
  read_distortion(file, "distortion_coefficients", camera);
  check_camera(file, "focal_length", "distortion_coefficients", camera);
  return camera;
}

// SVIn's pose graph: one camera whose keys stand at the top, image_width and image_height apart.
CameraModel read_pose_graph_camera(const Fields& file) {
  if (file.word("model_type") != "PINHOLE") {
    file.fail("model_type",
              '"' + file.word("model_type").substr(0, 40) + "\" is not PINHOLE, the one known",
              "calibrate with it");
  }
  CameraModel camera;
  read_size(file, "image_width", "image_height", camera);
  read_pinhole(file, camera);
  read_distortion(file, "distortion_coefficients", camera);
  check_camera(file, "principal_point", "distortion_coefficients", camera);
  return camera;
}

std::vector<Fields> cameras_of(const Fields& file) {
  if (!file.has("left_cam_params")) return file.list("cameras");
  std::vector<Fields> cameras = {file.inside("left_cam_params")};
  if (file.has("right_cam_params")) cameras.push_back(file.inside("right_cam_params"));
  return cameras;
}

bool has_camera(const Fields& file) {
  return file.has("focal_length") && file.has("principal_point");
}

}  // namespace

bool is_okvis(const Fields& file) {
  return file.is_sequence("cameras") || file.is_mapping("left_cam_params") || has_camera(file);
}

CameraRig read_okvis(const Fields& file) {
  CameraRig rig;
  if (has_camera(file)) {
    rig.left = read_pose_graph_camera(file);
    return rig;
  }
  const std::vector<Fields> cameras = cameras_of(file);
  if (cameras.empty() || cameras.size() > 2) {
    file.fail("cameras",
              "has " + std::to_string(cameras.size()) +
                  " cameras; which of them took the images is not known",
              "keep one, or two as left and right");
  }
  rig.left = read_camera(cameras[0]);
  if (cameras.size() == 1) return rig;
  const CameraModel right = read_camera(cameras[1]);
  if (right.width != rig.left.width || right.height != rig.left.height) return rig;  // no pair
  const Rigid3 right_from_left =
      read_transform(cameras[1], "T_SC").inverse() * read_transform(cameras[0], "T_SC");
  return pair(cameras[1], "T_SC", "T_SC", rig.left, right, right_from_left);
}

}  // namespace nadir::calibration
