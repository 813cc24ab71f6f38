// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "matching.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/features2d.hpp>

namespace nadir::odometry {
namespace {

// Bits that differ. cv::hal::normHamming takes longer to find out what it runs on.
int hamming(const std::uint8_t* a, const std::uint8_t* b) {
  int bits = 0;
  for (int i = 0; i < 32; i += 8) {
    std::uint64_t first = 0, second = 0;
    std::memcpy(&first, a + i, 8);
    std::memcpy(&second, b + i, 8);
    bits += std::popcount(first ^ second);
  }
  return bits;
}

// Features of an image by square cell.
class Cells {
 public:
  Cells(const std::vector<Eigen::Vector2d>& pixels, double side) : side_(side) {
    double width = 0, height = 0;
    for (const auto& p : pixels) width = std::max(width, p.x()), height = std::max(height, p.y());
    columns_ = static_cast<int>(width / side) + 1;
    rows_ = static_cast<int>(height / side) + 1;
    members_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int i = 0; i < static_cast<int>(pixels.size()); ++i) {
      const auto& p = pixels[static_cast<std::size_t>(i)];
      at(static_cast<int>(p.x() / side), static_cast<int>(p.y() / side)).push_back(i);
    }
  }

  template <class Visit>
  void visit_near(const Eigen::Vector2d& p, Visit visit) {
    const double x = std::floor(p.x() / side_), y = std::floor(p.y() / side_);
    if (!(x > -2 && y > -2 && x < columns_ + 1 && y < rows_ + 1)) return;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        for (const int i : at(c, r)) visit(i);
      }
    }
  }

 private:
  std::vector<int>& at(int column, int row) {
    return members_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(column)];
  }
  double side_;
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> members_;
};

}  // namespace

bool is_binary(const cv::Mat& descriptors) { return descriptors.cols == 32; }

Pairs match_descriptors(const cv::Mat& first, const cv::Mat& second, double ratio) {
  Pairs pairs;
  if (first.rows < 2 || second.rows < 2) return pairs;
  std::vector<std::vector<cv::DMatch>> nearest;
  if (is_binary(first)) {
    cv::BFMatcher(cv::NORM_HAMMING).knnMatch(first, second, nearest, 2);
  } else {  // of bytes OpenCV's Euclidean distance is not vectorised
    cv::Mat first_values, second_values;
    first.convertTo(first_values, CV_32F);
    second.convertTo(second_values, CV_32F);
    cv::BFMatcher(cv::NORM_L2).knnMatch(first_values, second_values, nearest, 2);
  }
  std::vector<cv::DMatch> taken(static_cast<std::size_t>(second.rows), cv::DMatch(-1, -1, 1e9F));
  for (const auto& n : nearest) {
    if (n.size() < 2 || !(n[0].distance < static_cast<float>(ratio) * n[1].distance)) continue;
    auto& owner = taken[static_cast<std::size_t>(n[0].trainIdx)];
    if (n[0].distance < owner.distance) owner = n[0];
  }
  for (const auto& m : taken) {
    if (m.queryIdx >= 0) pairs.emplace_back(m.queryIdx, m.trainIdx);
  }
  return pairs;
}

Pairs match_near(const cv::Mat& first, const std::vector<Eigen::Vector2d>& expected,
                 const Features& second, double radius_px, int max_distance) {
  Cells cells(second.pixels, radius_px);
  std::vector<std::pair<int, int>> owner(static_cast<std::size_t>(second.size()),
                                         {max_distance, -1});
  for (int i = 0; i < first.rows; ++i) {
    const auto& place = expected[static_cast<std::size_t>(i)];
    if (!place.allFinite()) continue;
    int best = -1, distance = max_distance;
    cells.visit_near(place, [&](int k) {
      if ((second.pixels[static_cast<std::size_t>(k)] - place).norm() > radius_px) return;
      const int d = hamming(first.ptr(i), second.descriptors.ptr(k));
      if (d < distance) distance = d, best = k;
    });
    if (best < 0) continue;
    auto& taken = owner[static_cast<std::size_t>(best)];
    if (distance < taken.first) taken = {distance, i};
  }
  Pairs pairs;
  for (int k = 0; k < second.size(); ++k) {
    const int i = owner[static_cast<std::size_t>(k)].second;
    if (i >= 0) pairs.emplace_back(i, k);
  }
  return pairs;
}

}  // namespace nadir::odometry
