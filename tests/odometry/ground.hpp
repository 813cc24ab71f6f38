// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A flat textured seabed at z = 0 and exact images of it from a camera with known pose.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <memory>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "nadir/core/frame.hpp"

namespace nadir::odometry {

inline CameraRig small_rig() {
  CameraRig rig;
  rig.left.width = 320;
  rig.left.height = 240;
  rig.left.fx = rig.left.fy = 300;
  rig.left.cx = 159.5;
  rig.left.cy = 119.5;
  return rig;
}

inline CameraRig small_pair() {
  CameraRig rig = small_rig();
  rig.right = CameraRig::Right{rig.left, {Eigen::Quaterniond::Identity(), {-0.1, 0, 0}}};
  rig.right->camera.fx = rig.right->camera.fy = 305;
  return rig;
}

/// survey_from_camera of a camera looking down from (x, y, altitude), turned by yaw, tilted a bit.
inline Rigid3 looking_down(double x, double y, double altitude, double yaw = 0, double tilt = 0) {
  const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond lean(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
  return {turn * down * lean, {x, y, altitude}};
}

class Ground {
 public:
  explicit Ground(unsigned seed = 1) : texture_(1200, 2400, CV_32F, cv::Scalar(0)) {
    cv::RNG random(seed);
    for (const double blur : {1.2, 3.0, 8.0}) {
      cv::Mat noise(texture_.size(), CV_32F);
      random.fill(noise, cv::RNG::NORMAL, 0, 40 * blur);
      cv::GaussianBlur(noise, noise, {}, blur);
      texture_ += noise;
    }
    texture_ += 110;
    texture_.convertTo(texture_, CV_8U);
  }

  /// The ground spans x from -1 to 5, y from -1.5 to 1.5 metres.
  cv::Mat image(const CameraModel& camera, const Rigid3& survey_from_camera, unsigned seed) const {
    constexpr double kPerMetre = 400;
    const Rigid3 camera_from_survey = survey_from_camera.inverse();
    const Eigen::Matrix3d r = camera_from_survey.rotation.toRotationMatrix();
    Eigen::Matrix3d image_from_ground;
    image_from_ground << r.col(0), r.col(1), camera_from_survey.translation;
    Eigen::Matrix3d texture_from_ground;
    texture_from_ground << kPerMetre, 0, kPerMetre, 0, -kPerMetre, 1.5 * kPerMetre, 0, 0, 1;
    const Eigen::Matrix3d h = texture_from_ground * (camera.matrix() * image_from_ground).inverse();
    cv::Mat matrix, result, noise(camera.height, camera.width, CV_16S);
    cv::eigen2cv(h, matrix);
    cv::warpPerspective(texture_, result, matrix, {camera.width, camera.height},
                        cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
    cv::RNG random(seed);
    random.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(result, noise, result, cv::noArray(), CV_8U);
    return result;
  }

  /// Shows what lies in an area, metres, once more: with its least x and largest y at (x, y).
  void repeat(double least_x, double largest_y, double width, double height, double x, double y) {
    constexpr double kPerMetre = 400;
    const auto place = [](double at_x, double at_y) {
      return cv::Point(cvRound(kPerMetre * (at_x + 1)), cvRound(kPerMetre * (1.5 - at_y)));
    };
    const cv::Size size(cvRound(kPerMetre * width), cvRound(kPerMetre * height));
    const cv::Mat from = texture_(cv::Rect(place(least_x, largest_y), size)).clone();
    from.copyTo(texture_(cv::Rect(place(x, y), size)));
  }

  std::shared_ptr<Shot> shot(std::uint64_t number, const std::shared_ptr<const CameraRig>& rig,
                             const Rigid3& pose) const {
    const auto seed = static_cast<unsigned>(number);
    cv::Mat right;
    if (rig->right) {
      right = image(rig->right->camera, pose * rig->right->right_from_left.inverse(), seed + 1000);
    }
    return shot_of(number, rig, image(rig->left, pose, seed), right);
  }

  static std::shared_ptr<Shot> shot_of(std::uint64_t number,
                                       const std::shared_ptr<const CameraRig>& rig, cv::Mat grey,
                                       cv::Mat right = {}) {
    auto frame = std::make_shared<Frame>();
    frame->image = number;
    frame->time = from_seconds(static_cast<double>(number));
    frame->rig = rig;
    frame->grey = std::move(grey);
    frame->right = std::move(right);
    cv::cvtColor(frame->grey, frame->colour, cv::COLOR_GRAY2BGR);
    auto shot = std::make_shared<Shot>();
    shot->image = number;
    shot->time = frame->time;
    shot->frame = std::move(frame);
    return shot;
  }

 private:
  cv::Mat texture_;
};

}  // namespace nadir::odometry
