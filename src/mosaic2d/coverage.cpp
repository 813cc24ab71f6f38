// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/coverage.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nadir::mosaic2d {
namespace {

constexpr double kCellsAcross = 32;  // of the first footprint
constexpr int kMostSide = 4096, kMargin = 64;

}  // namespace

Eigen::Vector2d Coverage::in_cells(const Eigen::Vector2d& ground) const {
  return (ground - origin_) / cell_;
}

void Coverage::add(std::span<const Eigen::Vector2d> footprint) {
  const auto finite = [](const Eigen::Vector2d& corner) { return corner.allFinite(); };
  if (footprint.size() < 3 || !std::ranges::all_of(footprint, finite)) return;
  Eigen::Vector2d low = footprint[0], high = footprint[0];
  for (const Eigen::Vector2d& corner : footprint) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  if (cell_ == 0) {
    const double across = (high - low).minCoeff();
    if (!(across > 0)) return;
    cell_ = across / kCellsAcross;
    origin_ = low;
  }
  make_room(low, high);
  constexpr int kFraction = 8;  // bits behind the point
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& corner : footprint) {
    // The centre of a cell is the pixel, as OpenCV has it.
    const Eigen::Vector2d at = (in_cells(corner).array() - 0.5) * (1 << kFraction);
    corners.emplace_back(static_cast<int>(std::lround(at.x())),
                         static_cast<int>(std::lround(at.y())));
  }
  cv::fillConvexPoly(seen_, corners, cv::Scalar(255), cv::LINE_8, kFraction);
}

void Coverage::make_room(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const auto outside = [&] {
    const Eigen::Vector2d first = in_cells(low), last = in_cells(high);
    return first.minCoeff() < 0 || last.x() >= seen_.cols || last.y() >= seen_.rows;
  };
  while (outside()) {
    const Eigen::Vector2d first = in_cells(low), last = in_cells(high);
    const auto before = [](double cells) {
      return cells < 0 ? static_cast<int>(std::ceil(-cells)) + kMargin : 0;
    };
    const auto behind = [](double cells, int size) {
      return cells >= size ? static_cast<int>(std::floor(cells)) + 1 - size + kMargin : 0;
    };
    const double farthest = std::max(first.cwiseAbs().maxCoeff(), last.cwiseAbs().maxCoeff());
    const bool fits = farthest < kMostSide && seen_.cols + before(first.x()) < kMostSide &&
                      seen_.rows + before(first.y()) < kMostSide;
    if (!fits) {
      coarsen();
      continue;
    }
    const int left = before(first.x()), above = before(first.y());
    cv::Mat wider;
    cv::copyMakeBorder(seen_.empty() ? cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)) : seen_, wider, above,
                       behind(last.y(), std::max(seen_.rows, 1)), left,
                       behind(last.x(), std::max(seen_.cols, 1)), cv::BORDER_CONSTANT,
                       cv::Scalar(0));
    seen_ = wider;
    origin_ -= cell_ * Eigen::Vector2d(left, above);
  }
}

// Cells of twice the side; one is seen when any of its four was.
void Coverage::coarsen() {
  cell_ *= 2;
  if (seen_.empty()) return;
  cv::copyMakeBorder(seen_, seen_, 0, seen_.rows % 2, 0, seen_.cols % 2, cv::BORDER_CONSTANT,
                     cv::Scalar(0));
  cv::Mat half(seen_.rows / 2, seen_.cols / 2, CV_8UC1);
  for (int y = 0; y < half.rows; ++y) {
    const auto *above = seen_.ptr<std::uint8_t>(2 * y), *below = seen_.ptr<std::uint8_t>(2 * y + 1);
    auto* to = half.ptr<std::uint8_t>(y);
    for (int x = 0; x < half.cols; ++x)
      to[x] = above[2 * x] | above[2 * x + 1] | below[2 * x] | below[2 * x + 1];
  }
  seen_ = half;
}

std::vector<std::vector<Eigen::Vector2d>> Coverage::outline() const {
  if (seen_.empty()) return {};
  // Outlines run through the centres of border cells: by twice as many of them, through their
  // edges.
  cv::Mat fine;
  cv::resize(seen_, fine, {}, 2, 2, cv::INTER_NEAREST);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(fine, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  for (const auto& contour : contours) {
    std::vector<cv::Point> simpler;
    constexpr double kWithin = 1.5;  // half cells
    cv::approxPolyDP(contour, simpler, kWithin, true);
    if (simpler.size() < 3) continue;
    std::vector<Eigen::Vector2d> polygon;
    for (const cv::Point& at : simpler)
      polygon.push_back(origin_ + cell_ * 0.5 * Eigen::Vector2d(at.x + 0.5, at.y + 0.5));
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

double Coverage::area() const {
  return seen_.empty() ? 0 : cell_ * cell_ * cv::countNonZero(seen_);
}

}  // namespace nadir::mosaic2d
