// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A seabed of described points and key frames of it, as odometry would settle them: exact but for
// the noise of the corners, in a live frame that may have drifted from the true one.
#pragma once

#include <memory>
#include <random>

#include "nadir/core/revision.hpp"
#include "odometry/ground.hpp"

namespace nadir::revisit {

class Seabed {
 public:
  static constexpr double kNoise_px = 0.3;

  /// Points from x = -2 to 8, y = -3 to 5 metres, with 0.2 m of relief.
  explicit Seabed(unsigned seed = 5) : random_(seed) {
    auto rig = std::make_shared<CameraRig>(odometry::small_rig());
    rig_ = rig;
    std::uniform_real_distribution<double> x(-2, 8), y(-3, 5);
    for (int i = 0; i < 12000; ++i) {
      Eigen::Vector3d p(x(random_), y(random_), 0);
      p.z() = 0.1 * std::sin(2 * p.x()) * std::cos(1.5 * p.y());
      points_.push_back(p);
    }
    descriptors_.create(static_cast<int>(points_.size()), 32, CV_8U);
    cv::RNG(seed).fill(descriptors_, cv::RNG::UNIFORM, 0, 256);
  }

  /// What lies in an area, metres, lies once more shifted by (x, y).
  void repeat(double least_x, double least_y, double width, double height, double x, double y) {
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d p = points_[i];
      if (p.x() < least_x || p.x() > least_x + width || p.y() < least_y || p.y() > least_y + height)
        continue;
      points_.emplace_back(p.x() + x, p.y() + y, p.z());
      descriptors_.push_back(descriptors_.row(static_cast<int>(i)).clone());
    }
  }

  /// live_from_true: where odometry believes the true frame to be at this image.
  std::shared_ptr<const SettledKeyFrame> key_frame(std::uint64_t image, std::uint32_t submap,
                                                   const Rigid3& true_from_camera,
                                                   const Similarity3& live_from_true) {
    auto result = std::make_shared<SettledKeyFrame>();
    result->rig = rig_;
    result->pose.image = image;
    result->pose.submap = submap;
    result->pose.key_frame = true;
    result->pose.survey_from_camera = live_from_true * true_from_camera;
    const Rigid3 camera_from_true = true_from_camera.inverse();
    std::normal_distribution<double> noise(0, kNoise_px / rig_->left.fx);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d x = camera_from_true * points_[i];
      const auto pixel = rig_->left.project(x);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > rig_->left.width - 1 ||
          pixel->y() > rig_->left.height - 1)
        continue;
      const Eigen::Vector2d ray = x.hnormalized() + Eigen::Vector2d(noise(random_), noise(random_));
      result->features.pixels.push_back(*pixel);
      result->features.rays.push_back(ray);
      result->features.descriptors.push_back(descriptors_.row(static_cast<int>(i)));
      // A map that is joined later knows the ground by other tie points.
      result->observations.push_back(
          {1'000'000 * submap + i, ray, std::nullopt, live_from_true * points_[i]});
    }
    return result;
  }

 private:
  std::mt19937 random_;
  std::shared_ptr<const CameraRig> rig_;
  std::vector<Eigen::Vector3d> points_;
  cv::Mat descriptors_;
};

}  // namespace nadir::revisit
