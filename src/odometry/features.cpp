// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "features.hpp"

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace nadir::odometry {
namespace {

constexpr int kDescribedSide = 1100;  // px: larger images are described at half size

// The strongest corners of every cell, so that a bright patch does not take them all.
std::vector<cv::KeyPoint> spread(std::vector<cv::KeyPoint> corners, cv::Size size, int wanted) {
  std::stable_sort(corners.begin(), corners.end(),
                   [](const auto& a, const auto& b) { return a.response > b.response; });
  const double cell = std::max(8.0, std::sqrt(size.area() * 6.0 / wanted));  // 6 corners a cell
  const int columns = static_cast<int>(size.width / cell) + 1;
  const int rows = static_cast<int>(size.height / cell) + 1;
  std::vector<int> taken(static_cast<std::size_t>(columns * rows), 0);
  std::vector<cv::KeyPoint> kept;
  for (const auto& corner : corners) {
    const int index =
        static_cast<int>(corner.pt.y / cell) * columns + static_cast<int>(corner.pt.x / cell);
    if (taken[static_cast<std::size_t>(index)]++ < 8) kept.push_back(corner);
    if (static_cast<int>(kept.size()) == wanted) break;
  }
  return kept;
}

cv::Mat equalised(const cv::Mat& grey, int divisor) {
  cv::Mat reduced, result;
  if (divisor > 1) cv::resize(grey, reduced, {}, 1.0 / divisor, 1.0 / divisor, cv::INTER_AREA);
  cv::createCLAHE(3.0, {8, 8})->apply(divisor > 1 ? reduced : grey, result);
  return result;
}

}  // namespace

Features detect_features(const cv::Mat& grey, const CameraModel& camera, int wanted,
                         int threshold) {
  const int divisor = std::max(grey.cols, grey.rows) > kDescribedSide ? 2 : 1;
  const cv::Mat image = equalised(grey, divisor);
  const auto orb =
      cv::ORB::create(wanted * 6, 1.2F, 5, 19, 0, 2, cv::ORB::HARRIS_SCORE, 31, threshold);
  std::vector<cv::KeyPoint> corners;
  orb->detect(image, corners);
  corners = spread(std::move(corners), image.size(), wanted);
  cv::Mat descriptors;
  orb->compute(image, corners, descriptors);

  Features features;
  features.descriptors.create(0, 32, CV_8U);
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    const auto& at = corners[static_cast<std::size_t>(i)].pt;
    const Eigen::Vector2d pixel((at.x + 0.5) * divisor - 0.5, (at.y + 0.5) * divisor - 0.5);
    const auto ray = camera.unproject(pixel);
    if (!ray) continue;
    features.pixels.push_back(pixel);
    features.rays.push_back(*ray);
    features.descriptors.push_back(descriptors.row(i));
  }
  return features;
}

std::shared_ptr<View> prepare_view(std::shared_ptr<const Frame> frame, int wanted) {
  auto view = std::make_shared<View>();
  cv::Mat laplacian, small;
  cv::resize(frame->grey, small, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::Laplacian(small, laplacian, CV_16S);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  view->sharpness = deviation[0] * deviation[0];
  view->exposure = cv::mean(small)[0];
  view->features = detect_features(frame->grey, frame->rig->left, wanted);
  view->frame = std::move(frame);
  return view;
}

}  // namespace nadir::odometry
