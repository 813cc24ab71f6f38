// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "features.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "nadir/image_io/reduce.hpp"

namespace nadir::odometry {
namespace {

// px: larger images are described at half size. Corners only lead to where patches are measured.
constexpr int kDescribedSide = 900;

constexpr int kPlenty = 4;  // times the wanted corners, so that few cells lack theirs
constexpr int kLevels = 3;
constexpr float kLevelScale = 1.3F;  // altitude changes little between images that overlap
constexpr int kDescriptorSide = 31;  // px at the corner's level
constexpr int kBorder = 19;          // px a described corner keeps from the border of its level

// The strongest corners of every cell, so that a bright patch does not take them all.
std::vector<cv::KeyPoint> spread(std::vector<cv::KeyPoint> corners, cv::Size size, int wanted) {
  constexpr int kPerCell = 4;
  std::stable_sort(corners.begin(), corners.end(),
                   [](const auto& a, const auto& b) { return a.response > b.response; });
  const double cell = std::max(8.0, std::sqrt(size.area() * (kPerCell - 1.0) / wanted));
  const int columns = static_cast<int>(size.width / cell) + 1;
  const int rows = static_cast<int>(size.height / cell) + 1;
  std::vector<int> taken(static_cast<std::size_t>(columns * rows), 0);
  std::vector<cv::KeyPoint> kept;
  for (const auto& corner : corners) {
    const int index =
        static_cast<int>(corner.pt.y / cell) * columns + static_cast<int>(corner.pt.x / cell);
    if (taken[static_cast<std::size_t>(index)]++ < kPerCell) kept.push_back(corner);
    if (static_cast<int>(kept.size()) == wanted) break;
  }
  return kept;
}

// Direction from the corner to the centroid of the grey levels around it, degrees (ORB).
float direction(const cv::Mat& image, const cv::Point2f& at) {
  constexpr int kRadius = kDescriptorSide / 2;
  const int x0 = cvRound(at.x), y0 = cvRound(at.y);
  int along_x = 0, along_y = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const std::uint8_t* row = image.ptr(y0 + y) + x0;
    const int reach = cvFloor(std::sqrt(static_cast<float>(kRadius * kRadius - y * y)));
    int sum = 0;
    for (int x = -reach; x <= reach; ++x) {
      along_x += x * row[x];
      sum += row[x];
    }
    along_y += y * sum;
  }
  return cv::fastAtan2(static_cast<float>(along_y), static_cast<float>(along_x));
}

// A well lit image has plenty far above the threshold, and fewer take less time.
std::vector<cv::KeyPoint> fast_corners(const cv::Mat& image, int wanted, int threshold) {
  std::vector<cv::KeyPoint> found;
  for (const int factor : {4, 2, 1}) {
    cv::FAST(image, found, factor * threshold);
    if (static_cast<int>(found.size()) >= kPlenty * wanted) break;
  }
  cv::KeyPointsFilter::runByImageBorder(found, image.size(), kBorder);
  return found;
}

// Corners of an image pyramid, in pixels of its first level.
std::vector<cv::KeyPoint> detect_corners(const cv::Mat& image, int wanted, int threshold) {
  std::vector<cv::KeyPoint> corners;
  cv::Mat level = image;
  float scale = 1;
  for (int octave = 0; octave < kLevels; ++octave, scale *= kLevelScale) {
    if (octave > 0) cv::resize(image, level, {}, 1 / scale, 1 / scale, cv::INTER_LINEAR);
    if (std::min(level.cols, level.rows) <= 2 * kBorder + 1) break;
    const int share =
        std::max(1, static_cast<int>(static_cast<float>(wanted) / (scale * scale * 1.95F)));
    for (auto& corner : spread(fast_corners(level, share, threshold), level.size(), share)) {
      corner.angle = direction(level, corner.pt);
      corner.octave = octave;
      corner.size = kDescriptorSide * scale;
      corner.pt *= scale;
      corners.push_back(corner);
    }
  }
  return corners;
}

cv::Mat equalised(const cv::Mat& grey, int divisor) {
  cv::Mat reduced, result;
  if (divisor > 1) cv::resize(grey, reduced, {}, 1.0 / divisor, 1.0 / divisor, cv::INTER_AREA);
  cv::createCLAHE(3.0, {8, 8})->apply(divisor > 1 ? reduced : grey, result);
  return result;
}

// Where the lens has no ray there is no feature.
void add(const Eigen::Vector2d& pixel, const cv::Mat& descriptor, const CameraModel& camera,
         Features& features) {
  const auto ray = camera.unproject(pixel);
  if (!ray) return;
  features.pixels.push_back(pixel);
  features.rays.push_back(*ray);
  features.descriptors.push_back(descriptor);
}

}  // namespace

Features detect_features(const cv::Mat& grey, const CameraModel& camera, int wanted,
                         int threshold) {
  const int divisor = std::max(grey.cols, grey.rows) > kDescribedSide ? 2 : 1;
  const cv::Mat image = equalised(grey, divisor);
  std::vector<cv::KeyPoint> corners = detect_corners(image, wanted, threshold);
  cv::Mat descriptors;
  cv::ORB::create(wanted, kLevelScale, kLevels, kBorder)->compute(image, corners, descriptors);

  Features features;
  features.descriptors.create(0, 32, CV_8U);
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    const auto& at = corners[static_cast<std::size_t>(i)].pt;
    const Eigen::Vector2d pixel((at.x + 0.5) * divisor - 0.5, (at.y + 0.5) * divisor - 0.5);
    add(pixel, descriptors.row(i), camera, features);
  }
  return features;
}

Features describe_blobs(const cv::Mat& grey, const CameraModel& camera) {
  constexpr int kBlobs = 700;
  const cv::Mat picture = small_picture(grey);
  const double x_scale = static_cast<double>(camera.width) / picture.cols;
  const double y_scale = static_cast<double>(camera.height) / picture.rows;
  std::vector<cv::KeyPoint> blobs;
  cv::Mat descriptors;
  cv::SIFT::create(kBlobs, 3, 0.01, 10, 1.6, CV_8U)
      ->detectAndCompute(equalised(picture, 1), cv::noArray(), blobs, descriptors);
  Features features;
  features.descriptors.create(0, 128, CV_8U);
  std::vector<int> order(blobs.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](int i) { return blobs[static_cast<std::size_t>(i)].response; });
  for (const int i : order) {
    const auto& at = blobs[static_cast<std::size_t>(i)].pt;
    const Eigen::Vector2d pixel((at.x + 0.5) * x_scale - 0.5, (at.y + 0.5) * y_scale - 0.5);
    add(pixel, descriptors.row(i), camera, features);
  }
  return features;
}

// Halves, which cost little, then a step under two, which needs no averaging.
cv::Mat small_picture(const cv::Mat& grey) {
  constexpr int kWidest = 640;
  if (grey.cols <= kWidest) return grey;
  const int rows = cvRound(static_cast<double>(grey.rows) * kWidest / grey.cols);
  cv::Mat half = grey, small;
  const auto is_even = [&] { return half.cols % 2 == 0 && half.rows % 2 == 0; };
  while (half.cols >= 2 * kWidest && is_even()) half = image_io::reduce(half, 2);
  const int how = half.cols < 2 * kWidest ? cv::INTER_LINEAR : cv::INTER_AREA;
  cv::resize(half, small, {kWidest, rows}, 0, 0, how);
  return small;
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
