// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// sensor_msgs/CameraInfo: K, D, R, P in ROS 1, in small letters in ROS 2.
#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

std::string key(const Fields& file, const char* ros_1, const char* ros_2) {
  return file.has(ros_2) ? ros_2 : ros_1;
}

// K is of the full resolution, the images are then smaller.
void refuse_part_of_the_sensor(const Fields& file) {
  const char* const kRemedy = "calibrate the images as they are stored";
  for (const char* binning : {"binning_x", "binning_y"}) {
    if (file.number_or_zero(binning) > 1) file.fail(binning, "bins pixels", kRemedy);
  }
  if (!file.is_mapping("roi")) return;
  for (const char* side : {"x_offset", "y_offset", "width", "height"}) {
    const Fields roi = file.inside("roi");
    if (roi.number_or_zero(side) != 0) roi.fail(side, "is a part of the image", kRemedy);
  }
}

}  // namespace

bool is_ros_camera_info(const Fields& file) {
  return file.has("width") && file.has("height") &&
         (file.is_sequence("K") || file.is_sequence("k"));
}

CameraRig read_ros_camera_info(const Fields& file) {
  const std::string matrix = key(file, "K", "k"), distortion = key(file, "D", "d");
  CameraModel camera;
  read_size(file, "width", "height", camera);
  camera.lens = read_lens(file, "distortion_model");
  const std::vector<double> k = file.numbers(matrix, 9);
  set_matrix(file, matrix, Eigen::Matrix3d(k.data()).transpose(), camera);
  read_distortion(file, distortion, camera);
  refuse_part_of_the_sensor(file);
  check_camera(file, matrix, distortion, camera);
  CameraRig rig;
  rig.left = camera;
  return rig;
}

}  // namespace nadir::calibration
