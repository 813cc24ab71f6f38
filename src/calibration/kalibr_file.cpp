// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// https://github.com/ethz-asl/kalibr/wiki/yaml-formats. Pixels as OpenCV's, metres.
#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

CameraModel read_camera(const Fields& file) {
  CameraModel camera;
  if (file.word("camera_model") != "pinhole") {
    file.fail("camera_model",
              '"' + file.word("camera_model").substr(0, 40) + "\" is not pinhole, the one known",
              "calibrate with --models pinhole-radtan or pinhole-equi");
  }
  read_size(file, "resolution", camera);
  const std::vector<double> intrinsics = file.numbers("intrinsics", 4);
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  if (file.word("distortion_model") != "none") {
    camera.lens = read_lens(file, "distortion_model");
    read_distortion(file, "distortion_coeffs", camera);
  }
  check_camera(file, "intrinsics", "distortion_coeffs", camera);
  return camera;
}

// OpenVINS writes the inverse of Kalibr's T_cam_imu.
Rigid3 read_camera_from_imu(const Fields& file) {
  if (file.has("T_imu_cam")) return read_transform(file, "T_imu_cam").inverse();
  return read_transform(file, "T_cam_imu");
}

CameraRig read_pair(const Fields& first, const Fields& second, const CameraModel& left,
                    const CameraModel& right) {
  const bool through_imu = first.has("T_imu_cam") || first.has("T_cam_imu");
  if (!second.has("T_cn_cnm1") && through_imu) {
    const std::string key = second.has("T_imu_cam") ? "T_imu_cam" : "T_cam_imu";
    return pair(second, key, key, left, right,
                read_camera_from_imu(second) * read_camera_from_imu(first).inverse());
  }
  return pair(second, "T_cn_cnm1", "T_cn_cnm1", left, right, read_transform(second, "T_cn_cnm1"));
}

}  // namespace

bool is_kalibr(const Fields& file) { return file.is_mapping("cam0"); }

CameraRig read_kalibr(const Fields& file) {
  if (file.has("cam2")) {
    file.fail("cam2", "is a third camera; which of them took the images is not known",
              "keep cam0, or cam0 and cam1 as left and right");
  }
  const Fields first = file.inside("cam0");
  CameraRig rig;
  rig.left = read_camera(first);
  if (!file.has("cam1")) return rig;
  const Fields second = file.inside("cam1");
  const CameraModel right = read_camera(second);
  // Cameras of two sizes are no pair: a colour and a depth camera, say. A wrong guess shows at the
  // first image.
  if (right.width != rig.left.width || right.height != rig.left.height) return rig;
  return read_pair(first, second, rig.left, right);
}

}  // namespace nadir::calibration
