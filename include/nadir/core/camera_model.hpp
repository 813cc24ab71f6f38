// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Calibrated cameras. Pixels follow OpenCV: the centre of the top-left pixel is (0, 0).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "nadir/core/rigid3.hpp"

namespace nadir {

enum class LensModel { brown_conrady, kannala_brandt };

/// A central camera. Brown-Conrady: k1 k2 p1 p2 k3 k4 k5 k6 as in OpenCV's calib3d;
/// Kannala-Brandt: k1 k2 k3 k4 as in OpenCV's fisheye, the rest zero.
struct CameraModel {
  int width = 0;  ///< px
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
  LensModel lens = LensModel::brown_conrady;
  std::array<double, 8> distortion{};

  /// Pixel of a point in the camera frame; none behind the camera or beyond the lens model's valid
  /// field.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  /// Normalised undistorted image coordinates (x/z, y/z) of a pixel; none where the model has no
  /// inverse.
  std::optional<Eigen::Vector2d> unproject(const Eigen::Vector2d& pixel) const;
  /// The same camera after its images were reduced by 1/divisor per side (1, 2 or 4), pixel areas
  /// averaged.
  CameraModel reduced(int divisor) const;
  Eigen::Matrix3d matrix() const;
  double mean_focal() const { return 0.5 * (fx + fy); }  ///< px
};

/// One camera, or a pair whose left camera is the reference.
struct CameraRig {
  struct Right {
    CameraModel camera;
    Rigid3 right_from_left;  ///< metres
  };
  CameraModel left;
  std::optional<Right> right;
  /// Mounting; default: the camera looks down, image top is forward (body is FRD).
  Eigen::Quaterniond body_from_camera{Eigen::Matrix3d{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};

  CameraRig reduced(int divisor) const;
};

/// Error that sub-pixel matching makes alike in all tie points of a pair, by the interpolation and
/// the lens; measured on rendered pairs, whose scale is off by less than it allows. Unlike each
/// point's own it does not average out.
inline constexpr double kSharedMatching_px = 0.02;

}  // namespace nadir
