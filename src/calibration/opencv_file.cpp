// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "camera_parts.hpp"
#include "formats.hpp"
#include "plausibility.hpp"

namespace nadir::calibration {
namespace {

using Eigen::MatrixXd;

MatrixXd sized_matrix(const Fields& file, const std::string& key, int rows, int columns) {
  MatrixXd matrix = file.matrix(key);
  if (matrix.rows() != rows || matrix.cols() != columns) {
    file.fail(key,
              "is " + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) +
                  ", expected " + std::to_string(rows) + " x " + std::to_string(columns),
              "correct it");
  }
  return matrix;
}

LensModel lens(const Fields& file) {
  // OpenCV's camera_calibration sample writes fisheye_model.
  if (file.has("fisheye_model") && file.integer("fisheye_model") != 0) {
    return LensModel::kannala_brandt;
  }
  return file.has("distortion_model") ? read_lens(file, "distortion_model")
                                      : LensModel::brown_conrady;
}

// Without a size, a matrix that cannot be at the size its own principal point suggests is refused
// for that: a size added to it would not help.
void check_without_size(const Fields& file) {
  if (file.has("image_width") || !file.has("camera_matrix")) return;
  CameraModel camera;
  set_matrix(file, "camera_matrix", sized_matrix(file, "camera_matrix", 3, 3), camera);
  camera.width = static_cast<int>(std::clamp(2 * camera.cx + 1, 2., 65535.));
  camera.height = static_cast<int>(std::clamp(2 * camera.cy + 1, 2., 65535.));
  if (const auto doubt = doubt_about_pinhole(camera)) {
    file.fail("camera_matrix", doubt->fault, doubt->remedy);
  }
}

CameraModel read_camera(const Fields& file, const std::string& suffix) {
  const std::string matrix = "camera_matrix" + suffix;
  const std::string distortion = "distortion_coefficients" + suffix;
  CameraModel camera;
  read_size(file, "image_width", "image_height", camera);
  camera.lens = lens(file);
  set_matrix(file, matrix, sized_matrix(file, matrix, 3, 3), camera);
  read_distortion(file, distortion, camera);
  check_camera(file, matrix, distortion, camera);
  return camera;
}

bool describes_a_pair(const Fields& file) {
  for (const char* key : {"camera_matrix_right", "distortion_coefficients_right", "R", "T"}) {
    if (file.has(key)) return true;
  }
  return false;
}

}  // namespace

CameraRig read_opencv(const Fields& file) {
  check_without_size(file);
  CameraRig rig;
  rig.left = read_camera(file, "");
  if (!describes_a_pair(file)) return rig;
  const CameraModel right = read_camera(file, "_right");
  const auto rotation = nearest_rotation(file, "R", sized_matrix(file, "R", 3, 3));
  const std::vector<double> t = file.numbers("T", 3);
  return pair(file, "R", "T", rig.left, right, {rotation, {t[0], t[1], t[2]}});
}

}  // namespace nadir::calibration
