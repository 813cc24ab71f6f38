// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/calibration/rig_file.hpp"

#include <Eigen/SVD>

#include "fields.hpp"
#include "plausibility.hpp"

namespace nadir::calibration {
namespace {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d;

MatrixXd sized_matrix(const FieldFile& file, const std::string& key, int rows, int columns) {
  MatrixXd matrix = file.matrix(key);
  if (matrix.rows() != rows || matrix.cols() != columns) {
    file.fail(key,
              "is " + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) +
                  ", expected " + std::to_string(rows) + " x " + std::to_string(columns),
              "correct it");
  }
  return matrix;
}

void read_size(const FieldFile& file, CameraModel& camera) {
  camera.width = file.integer("image_width");
  camera.height = file.integer("image_height");
  constexpr int kSmallest = 16, kLargest = 65535;
  for (const auto& [key, side] :
       {std::pair{"image_width", camera.width}, std::pair{"image_height", camera.height}}) {
    if (side < kSmallest || side > kLargest) {
      file.fail(key, std::to_string(side) + " px is no image size", "correct it");
    }
  }
}

void read_matrix(const FieldFile& file, const std::string& key, CameraModel& camera) {
  const Matrix3d k = sized_matrix(file, key, 3, 3);
  constexpr double kZero = 1e-9;
  if (std::abs(k(1, 0)) > kZero || !k.row(2).isApprox(Vector3d::UnitZ().transpose(), kZero)) {
    file.fail(key, "is not of the form fx 0 cx, 0 fy cy, 0 0 1", "correct it");
  }
  if (std::abs(k(0, 1)) > kZero) {
    file.fail(key, "has a skew, which the lens model does not know", "calibrate without skew");
  }
  camera.fx = k(0, 0);
  camera.fy = k(1, 1);
  camera.cx = k(0, 2);
  camera.cy = k(1, 2);
}

LensModel read_lens(const FieldFile& file) {
  if (!file.has("distortion_model")) return LensModel::brown_conrady;
  const std::string name = file.word("distortion_model");
  if (name == "brown_conrady" || name == "plumb_bob" || name == "rational_polynomial") {
    return LensModel::brown_conrady;
  }
  if (name == "kannala_brandt" || name == "equidistant") return LensModel::kannala_brandt;
  file.fail("distortion_model", "is neither brown_conrady nor kannala_brandt",
            "use one of the two");
}

void read_distortion(const FieldFile& file, const std::string& key, CameraModel& camera) {
  const MatrixXd values = file.matrix(key);
  const auto count = values.size();
  const bool fisheye = camera.lens == LensModel::kannala_brandt;
  const bool known = fisheye ? count == 4 : count == 4 || count == 5 || count == 8;
  if (!known || (values.rows() != 1 && values.cols() != 1)) {
    file.fail(key,
              "has " + std::to_string(values.rows()) + " x " + std::to_string(values.cols()) +
                  " values; " +
                  (fisheye ? "kannala_brandt takes k1 k2 k3 k4"
                           : "brown_conrady takes 4, 5 or 8: k1 k2 p1 p2 k3 k4 k5 k6"),
              "calibrate with such a model");
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    camera.distortion[static_cast<std::size_t>(i)] = values(i);
  }
}

CameraModel read_camera(const FieldFile& file, const std::string& suffix) {
  CameraModel camera;
  read_size(file, camera);
  camera.lens = read_lens(file);
  const std::string matrix = "camera_matrix" + suffix;
  const std::string distortion = "distortion_coefficients" + suffix;
  read_matrix(file, matrix, camera);
  read_distortion(file, distortion, camera);
  if (const auto doubt = doubt_about_pinhole(camera))
    file.fail(matrix, doubt->fault, doubt->remedy);
  if (const auto doubt = doubt_about_lens(camera)) {
    file.fail(distortion, doubt->fault, doubt->remedy);
  }
  return camera;
}

// Printed rotations are rounded: the nearest true one is taken when it is close.
Eigen::Quaterniond read_rotation(const FieldFile& file) {
  constexpr double kRounding = 1e-3;
  const Matrix3d given = sized_matrix(file, "R", 3, 3);
  const Eigen::JacobiSVD<Matrix3d> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  if (nearest.determinant() < 0 || (nearest - given).cwiseAbs().maxCoeff() > kRounding) {
    file.fail("R", "is not a rotation matrix", "calibrate the pair again");
  }
  return Eigen::Quaterniond(nearest).normalized();
}

Vector3d read_translation(const FieldFile& file) {
  const MatrixXd t = file.matrix("T");
  if (t.size() != 3) file.fail("T", "has not three values", "correct it");
  return {t(0), t(1), t(2)};
}

bool describes_a_pair(const FieldFile& file) {
  for (const char* key : {"camera_matrix_right", "distortion_coefficients_right", "R", "T"}) {
    if (file.has(key)) return true;
  }
  return false;
}

}  // namespace

CameraRig load_rig(const std::filesystem::path& path) {
  const FieldFile file(path);
  CameraRig rig;
  rig.left = read_camera(file, "");
  if (!describes_a_pair(file)) return rig;
  const CameraModel right = read_camera(file, "_right");
  const Rigid3 right_from_left{read_rotation(file), read_translation(file)};
  if (const auto doubt = doubt_about_pair(right_from_left)) {
    file.fail(doubt->key, doubt->fault, doubt->remedy);
  }
  rig.right = CameraRig::Right{right, right_from_left};
  return rig;
}

}  // namespace nadir::calibration
