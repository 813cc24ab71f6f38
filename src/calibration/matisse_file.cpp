// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Ifremer's Matisse: OpenCV FileStorage of K and openMVG's lens models by number, as its
// Init3DRecon hands them on. https://github.com/IfremerUnderwater/Matisse
#include <algorithm>

#include "camera_parts.hpp"
#include "formats.hpp"

namespace nadir::calibration {
namespace {

// 0: k1. 1: k1 k2 k3. 2: k1 k2 k3 t1 t2, t being OpenCV's p. 3: fisheye, k1 k2 k3 k4. Longer lists
// are filled up with zeros; what stands beyond the model's own coefficients is not used by Matisse.
void read_distortion_of(const Fields& file, int model, CameraModel& camera) {
  const Eigen::MatrixXd given = file.matrix("distortion_coeff");
  constexpr Eigen::Index kCounts[] = {1, 3, 5, 4};
  const Eigen::Index count = kCounts[model];
  const bool surplus =
      given.size() > count && !given.reshaped().tail(given.size() - count).isZero(0);
  if (given.size() < count || surplus || (given.rows() != 1 && given.cols() != 1)) {
    file.fail("distortion_coeff",
              "are not the " + std::to_string(count) + " coefficients of distortion_model " +
                  std::to_string(model),
              "correct one or the other");
  }
  constexpr std::size_t kPlaces[][5] = {{0}, {0, 1, 4}, {0, 1, 4, 2, 3}, {0, 1, 2, 3}};
  for (Eigen::Index i = 0; i < count; ++i) camera.distortion[kPlaces[model][i]] = given(i);
}

}  // namespace

bool is_matisse(const Fields& file) { return file.has("full_sensor_width"); }

CameraRig read_matisse(const Fields& file) {
  CameraModel camera;
  read_size(file, "full_sensor_width", "full_sensor_height", camera);
  const int model = file.integer("distortion_model");
  if (model < 0 || model > 3) {
    file.fail("distortion_model", "is none of Matisse's 0 to 3", "correct it");
  }
  if (model == 3) camera.lens = LensModel::kannala_brandt;
  const std::vector<double> k = file.numbers("K", 9);
  set_matrix(file, "K", Eigen::Matrix3d(k.data()).transpose(), camera);
  read_distortion_of(file, model, camera);
  check_camera(file, "K", "distortion_coeff", camera);
  CameraRig rig;
  rig.left = camera;
  return rig;
}

}  // namespace nadir::calibration
