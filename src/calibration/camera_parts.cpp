// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "camera_parts.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "plausibility.hpp"

namespace nadir::calibration {
namespace {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d;

int side(const Fields& file, const std::string& key, double given) {
  constexpr double kSmallest = 16, kLargest = 65535;
  if (given != std::floor(given)) file.fail(key, "is not a whole number", "correct it");
  if (!(given >= kSmallest && given <= kLargest)) {
    file.fail(key, std::to_string(static_cast<long>(given)) + " px is no image size", "correct it");
  }
  return static_cast<int>(given);
}

}  // namespace

void read_size(const Fields& file, const std::string& width_key, const std::string& height_key,
               CameraModel& camera) {
  const int width = file.integer(width_key), height = file.integer(height_key);
  camera.width = side(file, width_key, width);
  camera.height = side(file, height_key, height);
}

void read_size(const Fields& file, const std::string& key, CameraModel& camera) {
  const std::vector<double> size = file.numbers(key, 2);
  camera.width = side(file, key, std::clamp(size[0], -1e9, 1e9));
  camera.height = side(file, key, std::clamp(size[1], -1e9, 1e9));
}

void set_matrix(const Fields& file, const std::string& key, const Matrix3d& k,
                CameraModel& camera) {
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

LensModel read_lens(const Fields& file, const std::string& key) {
  constexpr std::array<std::string_view, 6> kBrownConrady = {
      "brown_conrady", "plumb_bob",        "rational_polynomial",
      "radtan",        "radialtangential", "radialtangential8"};
  constexpr std::array<std::string_view, 3> kKannalaBrandt = {"kannala_brandt", "equidistant",
                                                              "fisheye"};
  const std::string name = file.word(key);
  if (std::ranges::find(kBrownConrady, name) != kBrownConrady.end()) {
    return LensModel::brown_conrady;
  }
  if (std::ranges::find(kKannalaBrandt, name) != kKannalaBrandt.end()) {
    return LensModel::kannala_brandt;
  }
  file.fail(key,
            '"' + name.substr(0, 40) +
                "\" is neither brown_conrady (plumb_bob, rational_polynomial, radtan, "
                "radialtangential) nor kannala_brandt (equidistant, fisheye)",
            "calibrate with one of the two");
}

void read_distortion(const Fields& file, const std::string& key, CameraModel& camera) {
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

void check_camera(const Fields& file, const std::string& matrix_key,
                  const std::string& distortion_key, const CameraModel& camera) {
  if (const auto doubt = doubt_about_pinhole(camera)) {
    file.fail(matrix_key, doubt->fault, doubt->remedy);
  }
  if (const auto doubt = doubt_about_lens(camera)) {
    file.fail(distortion_key, doubt->fault, doubt->remedy);
  }
}

Eigen::Quaterniond nearest_rotation(const Fields& file, const std::string& key,
                                    const Matrix3d& given) {
  constexpr double kRounding = 1e-3;
  const Eigen::JacobiSVD<Matrix3d> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  if (nearest.determinant() < 0 || (nearest - given).cwiseAbs().maxCoeff() > kRounding) {
    file.fail(key, "is not a rotation matrix", "calibrate the pair again");
  }
  return Eigen::Quaterniond(nearest).normalized();
}

Rigid3 read_transform(const Fields& file, const std::string& key) {
  const std::vector<double> values = file.numbers(key, 16);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> t(values.data());
  if (!t.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1))) {
    file.fail(key, "does not end with the row 0 0 0 1", "correct it");
  }
  return {nearest_rotation(file, key, t.topLeftCorner<3, 3>()), t.topRightCorner<3, 1>()};
}

CameraRig pair(const Fields& file, const std::string& rotation_key,
               const std::string& translation_key, const CameraModel& left,
               const CameraModel& right, const Rigid3& right_from_left) {
  if (const auto doubt = doubt_about_pair(right_from_left)) {
    file.fail(doubt->about_rotation ? rotation_key : translation_key, doubt->fault, doubt->remedy);
  }
  CameraRig rig;
  rig.left = left;
  rig.right = CameraRig::Right{right, right_from_left};
  return rig;
}

}  // namespace nadir::calibration
