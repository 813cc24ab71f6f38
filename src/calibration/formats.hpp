// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The calibration files that are read: one function each, and how each is told by its content.
// Each returns a plausible rig or throws InputError "FILE:LINE: KEY: fault; remedy".
#pragma once

#include <string>

#include "fields.hpp"
#include "nadir/core/camera_model.hpp"

namespace nadir::calibration {

/// OpenCV FileStorage and the file of ROS's camera_calibration; also nadir's own calib.yml.
CameraRig read_opencv(const Fields& file);

/// A camera_info message as `rostopic echo` and `ros2 topic echo` print it.
bool is_ros_camera_info(const Fields& file);
CameraRig read_ros_camera_info(const Fields& file);

/// Kalibr's camchain and imu-camchain, OpenVINS' variant included.
bool is_kalibr(const Fields& file);
CameraRig read_kalibr(const Fields& file);

/// OKVIS, with the variants of TURTLMap (left_cam_params) and of SVIn's pose graph (one camera).
bool is_okvis(const Fields& file);
CameraRig read_okvis(const Fields& file);

/// ORB-SLAM 2 and 3, one camera.
bool is_orb_slam(const Fields& file);
CameraRig read_orb_slam(const Fields& file);

/// Ifremer's Matisse.
bool is_matisse(const Fields& file);
CameraRig read_matisse(const Fields& file);

/// Agisoft Metashape and PhotoScan: a camera calibration or a cameras file, XML.
bool is_metashape(const Fields& file);
CameraRig read_metashape(const Fields& file);

/// COLMAP's cameras.txt.
bool is_colmap(const std::string& text);
CameraRig read_colmap(const std::string& text, const std::string& file);

}  // namespace nadir::calibration
