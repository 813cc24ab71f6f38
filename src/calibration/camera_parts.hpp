// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What every calibration format says in its own words: the pieces of a camera and of a pair. All
// throw InputError naming the key when the values cannot be.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fields.hpp"
#include "nadir/core/camera_model.hpp"

namespace nadir::calibration {

/// Width and height, px, under a key each.
void read_size(const Fields& file, const std::string& width_key, const std::string& height_key,
               CameraModel& camera);
/// A list [width, height].
void read_size(const Fields& file, const std::string& key, CameraModel& camera);

/// fx 0 cx, 0 fy cy, 0 0 1, px.
void set_matrix(const Fields& file, const std::string& key, const Eigen::Matrix3d& matrix,
                CameraModel& camera);

/// The lens model by any of the names that OpenCV, ROS, Kalibr and OKVIS give it.
LensModel read_lens(const Fields& file, const std::string& key);

/// k1 k2 p1 p2 [k3 [k4 k5 k6]], or k1 k2 k3 k4 of a fisheye: camera.lens is already set.
void read_distortion(const Fields& file, const std::string& key, CameraModel& camera);

/// Refuses a camera that cannot map a seabed. The keys: where its matrix and its distortion stand.
void check_camera(const Fields& file, const std::string& matrix_key,
                  const std::string& distortion_key, const CameraModel& camera);

/// The nearest rotation: printed ones are rounded.
Eigen::Quaterniond nearest_rotation(const Fields& file, const std::string& key,
                                    const Eigen::Matrix3d& matrix);

/// A 4 x 4 rigid transform, metres.
Rigid3 read_transform(const Fields& file, const std::string& key);

/// Two cameras of one file as a pair, which is checked. The keys: where the rotation and the
/// translation stand.
CameraRig pair(const Fields& file, const std::string& rotation_key,
               const std::string& translation_key, const CameraModel& left,
               const CameraModel& right, const Rigid3& right_from_left);

}  // namespace nadir::calibration
