// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A map of flat ground at z = 0 in units of its own, and orientations of images above it.
#pragma once

#include <memory>
#include <random>

#include "nadir/core/window.hpp"

namespace nadir::reference {

struct FlatGround {
  double metres_per_unit = 1;
  double hz = 2;
  Scale scale{};
  std::mt19937 random{3};
  std::uint64_t images = 0;
  std::shared_ptr<const CameraRig> rig = [] {
    auto made = std::make_shared<CameraRig>();
    made->left = {640, 480, 500, 500, 319.5, 239.5, LensModel::brown_conrady, {}};
    return made;
  }();

  double noise(double sigma) { return std::normal_distribution<double>(0, sigma)(random); }

  /// An image straight above (x, 0), metres, turned by roll; what its sensors say is up to the
  /// caller.
  struct Image {
    std::shared_ptr<Frame> frame = std::make_shared<Frame>();
    ImagePose pose;
  };
  Image image(double x, double height, double roll = 0) {
    Image made;
    made.frame->image = made.pose.image = images++;
    made.frame->time = made.pose.time = from_seconds(static_cast<double>(made.pose.image) / hz);
    made.frame->rig = rig;
    const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    made.pose.survey_from_camera = {
        Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX())) * down,
        Eigen::Vector3d(x, 0, height) / metres_per_unit};
    return made;
  }

  /// With a window of tie points all around.
  Orientation orientation(const Image& image, SurveyAxes axes = SurveyAxes::attitude) {
    auto window = std::make_shared<Window>();
    window->images = {image.pose};
    window->axes = axes;
    window->scale = scale;
    const Eigen::Vector3d& centre = image.pose.survey_from_camera.translation;
    std::uniform_real_distribution<double> reach(-0.6, 0.6);
    for (int i = 0; i < 300; ++i) {
      TiePoint point;
      point.x_in_survey = {centre.x() + centre.z() * reach(random), centre.z() * reach(random), 0};
      window->tie_points.push_back(point);
    }
    Orientation orientation;
    auto shot = std::make_shared<Shot>();
    shot->image = image.frame->image;
    shot->time = image.frame->time;
    shot->frame = image.frame;
    orientation.shot = shot;
    orientation.poses = {image.pose};
    orientation.window = window;
    return orientation;
  }
};

}  // namespace nadir::reference
