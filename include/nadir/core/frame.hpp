// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One image of the input as capture delivers it.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nadir/core/alert.hpp"
#include "nadir/core/camera_model.hpp"
#include "nadir/core/time.hpp"

namespace nadir {

/// Tait-Bryan Z-Y-X angles from body (FRD) to north-east-down, radians; yaw 0 is north, pi/2 east.
struct Attitude {
  double roll = 0, pitch = 0, yaw = 0;
  Eigen::Quaterniond ned_from_body() const {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    return Eigen::Quaterniond(AngleAxisd(yaw, Vector3d::UnitZ()) *
                              AngleAxisd(pitch, Vector3d::UnitY()) *
                              AngleAxisd(roll, Vector3d::UnitX()));
  }
};

/// A disc of an image.
struct Disc {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double radius_px = 0;
};

/// How far the ground is along a ray of the left camera, as a laser shows it.
struct Range {
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< x/z, y/z, undistorted
  double depth = 0;                               ///< along the optical axis, metres
  double sigma = 0;                               ///< relative
};

/// A decoded image or pair at the processed scale. Pixel data are never written after publication.
struct Frame {
  std::uint64_t image = 0;  ///< index in input order
  Time time = 0;
  std::string name;                      ///< file name without extension
  std::shared_ptr<const CameraRig> rig;  ///< at the processed scale
  cv::Mat colour;            ///< CV_8UC3 BGR of the left camera (grey input: three equal channels)
  cv::Mat grey;              ///< CV_8UC1 of the left camera
  cv::Mat right;             ///< CV_8UC1 of the right camera; empty when mono
  std::vector<Disc> hidden;  ///< where colour shows no seabed but the dots of lasers
  std::vector<Range> ranges;
  std::optional<Attitude> attitude;
  std::optional<double> depth;     ///< metres below the surface
  std::optional<double> altitude;  ///< metres to the seabed along the sounder
};

/// Images as the camera gave them, JPEG files.
struct OriginalImages {
  std::vector<std::uint8_t> left, right;  ///< right empty when mono
};

/// What became of one image of the input: a frame, or the alerts that say why not.
/// Image numbers may skip: those between two shots were missed by the camera, or dropped by a full
/// queue, and are counted here.
struct Shot {
  std::uint64_t image = 0;
  Time time = 0;
  std::string name;
  std::shared_ptr<const Frame> frame;  ///< null when the image was rejected
  std::vector<Alert> alerts;
  std::uint32_t dropped_before = 0;
  std::uint32_t missed_before = 0;
  std::shared_ptr<const OriginalImages> originals{};  ///< of live cameras, when they are to be kept
};

}  // namespace nadir
