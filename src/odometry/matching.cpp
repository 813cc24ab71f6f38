// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "matching.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <utility>
#include <vector>

#include "nadir/core/clones.hpp"

namespace nadir::odometry {
namespace {

constexpr int kBytes = 32;  // of a binary descriptor

// Bits that differ. cv::hal::normHamming takes longer to find out what it runs on.
inline int hamming(const std::uint8_t* a, const std::uint8_t* b) {
  int bits = 0;
  for (int i = 0; i < kBytes; i += 8) {
    std::uint64_t first = 0, second = 0;
    std::memcpy(&first, a + i, 8);
    std::memcpy(&second, b + i, 8);
    bits += std::popcount(first ^ second);
  }
  return bits;
}

struct Nearest {
  int index = -1;
  int distance = 8 * kBytes + 1, next_distance = 8 * kBytes + 1;
};

NADIR_CLONES
Nearest nearest(const std::uint8_t* wanted, const std::uint8_t* all, int count) {
  Nearest found;
  for (int k = 0; k < count; ++k) {
    const int distance = hamming(wanted, all + std::ptrdiff_t{kBytes} * k);
    if (distance < found.distance) {
      found = {k, distance, found.distance};
    } else if (distance < found.next_distance) {
      found.next_distance = distance;
    }
  }
  return found;
}

NADIR_CLONES
Nearest nearest_of(const std::uint8_t* wanted, const std::uint8_t* all,
                   const std::vector<int>& some) {
  Nearest found;
  for (const int k : some) {
    const int distance = hamming(wanted, all + std::ptrdiff_t{kBytes} * k);
    if (distance < found.distance) found.distance = distance, found.index = k;
  }
  return found;
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

// Each feature of the second goes to the one of the first that is nearest to it.
class Owners {
 public:
  explicit Owners(int count) : owners_(static_cast<std::size_t>(count), {-1, 0.0}) {}

  void claim(int first, int second, double distance) {
    auto& [owner, nearest] = owners_[static_cast<std::size_t>(second)];
    if (owner < 0 || distance < nearest) owner = first, nearest = distance;
  }
  Pairs pairs() const {
    Pairs pairs;
    for (int k = 0; k < static_cast<int>(owners_.size()); ++k) {
      const int owner = owners_[static_cast<std::size_t>(k)].first;
      if (owner >= 0) pairs.emplace_back(owner, k);
    }
    return pairs;
  }

 private:
  std::vector<std::pair<int, double>> owners_;  ///< feature of the first, -1: none; distance
};

cv::Mat continuous(const cv::Mat& rows) { return rows.isContinuous() ? rows : rows.clone(); }

Pairs distinct_binary(const cv::Mat& first, const cv::Mat& second, double ratio) {
  const cv::Mat all = continuous(second);
  Owners owners(second.rows);
  for (int i = 0; i < first.rows; ++i) {
    const Nearest n = nearest(first.ptr(i), all.ptr(), all.rows);
    if (n.distance < ratio * n.next_distance) owners.claim(i, n.index, n.distance);
  }
  return owners.pairs();
}

Pairs distinct_blobs(const cv::Mat& first, const cv::Mat& second, double ratio) {
  // Of bytes OpenCV's Euclidean distance is not vectorised.
  cv::Mat first_values, second_values;
  first.convertTo(first_values, CV_32F);
  second.convertTo(second_values, CV_32F);
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(cv::NORM_L2).knnMatch(first_values, second_values, nearest, 2);
  Owners owners(second.rows);
  for (const auto& n : nearest) {
    if (n.size() < 2 || !(n[0].distance < static_cast<float>(ratio) * n[1].distance)) continue;
    owners.claim(n[0].queryIdx, n[0].trainIdx, n[0].distance);
  }
  return owners.pairs();
}

}  // namespace

bool is_binary(const cv::Mat& descriptors) { return descriptors.cols == 32; }

Pairs match_descriptors(const cv::Mat& first, const cv::Mat& second, double ratio) {
  if (first.rows < 2 || second.rows < 2) return {};
  return is_binary(first) ? distinct_binary(first, second, ratio)
                          : distinct_blobs(first, second, ratio);
}

Pairs match_near(const cv::Mat& first, const std::vector<Eigen::Vector2d>& expected,
                 const Features& second, double radius_px, int max_distance) {
  Cells cells(second.pixels, radius_px);
  const cv::Mat all = continuous(second.descriptors);
  Owners owners(second.size());
  std::vector<int> near;
  for (int i = 0; i < first.rows; ++i) {
    const auto& place = expected[static_cast<std::size_t>(i)];
    if (!place.allFinite()) continue;
    near.clear();
    cells.visit_near(place, [&](int k) {
      if ((second.pixels[static_cast<std::size_t>(k)] - place).norm() <= radius_px)
        near.push_back(k);
    });
    const Nearest n = nearest_of(first.ptr(i), all.ptr(), near);
    if (n.index >= 0 && n.distance < max_distance) owners.claim(i, n.index, n.distance);
  }
  return owners.pairs();
}

}  // namespace nadir::odometry
