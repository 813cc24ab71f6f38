// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/camera_model.hpp"

#include <Eigen/LU>
#include <cmath>

#include "nadir/core/check.hpp"

namespace nadir {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

struct Distorted {
  Vector2d value;
  Matrix2d jacobian;
};

// OpenCV calib3d, "Detailed Description": radial k1-k6, tangential p1 p2.
Distorted brown_conrady(const std::array<double, 8>& k, const Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double numerator = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double denominator = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double radial = numerator / denominator;
  const double numerator_slope = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);
  const double denominator_slope = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  const double slope =
      (numerator_slope - radial * denominator_slope) / denominator;  // d radial / d r2
  const double p1 = k[2], p2 = k[3];
  Distorted d;
  d.value = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  const double cross = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  d.jacobian << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, cross,  //
      cross, radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return d;
}

// Kannala and Brandt 2006 as in OpenCV's fisheye: theta (1 + k1 theta^2 + ... + k4 theta^8).
Distorted kannala_brandt(const std::array<double, 8>& k, const Vector2d& p) {
  const double r = p.norm();
  if (r < 1e-9) return {p, Matrix2d::Identity()};
  const double theta = std::atan(r), t2 = theta * theta;
  const double bent = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double bent_slope =
      (1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])))) / (1 + r * r);
  const Vector2d direction = p / r;
  const Matrix2d along = direction * direction.transpose();
  return {direction * bent, along * bent_slope + (Matrix2d::Identity() - along) * (bent / r)};
}

Distorted distort(const CameraModel& camera, const Vector2d& p) {
  return camera.lens == LensModel::brown_conrady ? brown_conrady(camera.distortion, p)
                                                 : kannala_brandt(camera.distortion, p);
}

// Beyond the fold of its polynomial a lens model maps two rays to one pixel.
bool one_to_one(const Distorted& d) {
  return d.jacobian.trace() > 0 && d.jacobian.determinant() > 0;
}

}  // namespace

std::optional<Vector2d> CameraModel::project(const Eigen::Vector3d& x_in_camera) const {
  if (!(x_in_camera.z() > 0)) return std::nullopt;
  const Distorted d = distort(*this, x_in_camera.head<2>() / x_in_camera.z());
  if (!d.value.allFinite() || !one_to_one(d)) return std::nullopt;
  return Vector2d(fx * d.value.x() + cx, fy * d.value.y() + cy);
}

std::optional<Vector2d> CameraModel::unproject(const Vector2d& pixel) const {
  constexpr int kIterations = 20;  // Newton from the distorted point; lenses in use need 3 to 6
  constexpr double kConverged = 1e-10;  // of the focal length
  const Vector2d wanted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Vector2d p = wanted;
  for (int i = 0; i < kIterations; ++i) {
    const Distorted d = distort(*this, p);
    if (!d.value.allFinite() || !one_to_one(d)) return std::nullopt;
    const Vector2d error = d.value - wanted;
    if (error.norm() < kConverged) return p;
    p -= d.jacobian.inverse() * error;
  }
  return std::nullopt;
}

CameraModel CameraModel::reduced(int divisor) const {
  NADIR_CHECK(divisor >= 1, divisor);
  CameraModel camera = *this;
  camera.width = (width + divisor - 1) / divisor;
  camera.height = (height + divisor - 1) / divisor;
  camera.fx = fx / divisor;
  camera.fy = fy / divisor;
  camera.cx = (cx + 0.5) / divisor - 0.5;
  camera.cy = (cy + 0.5) / divisor - 0.5;
  return camera;
}

Eigen::Matrix3d CameraModel::matrix() const {
  return Eigen::Matrix3d{{fx, 0, cx}, {0, fy, cy}, {0, 0, 1}};
}

CameraRig CameraRig::reduced(int divisor) const {
  CameraRig rig = *this;
  rig.left = left.reduced(divisor);
  if (rig.right) rig.right->camera = right->camera.reduced(divisor);
  return rig;
}

}  // namespace nadir
