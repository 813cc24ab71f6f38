// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/seen_ground.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nadir::coverage {
namespace {

constexpr double kCellsAcross = 32;  // of the first footprint
// There are two rasters while it grows, and a bit of each cell while it is outlined.
constexpr int kMostSide = 2560, kMargin = 64;

/// Cells that a raster of a size lacks to hold what reaches from first to last.
struct Lack {
  double before = 0, behind = 0;

  Lack(double first, double last, int size)
      : before(first < 0 ? std::ceil(-first) + kMargin : 0),
        behind(last >= size ? std::floor(last) + 1 - size + kMargin : 0) {}
  bool fits(int size) const { return before + size + behind <= kMostSide; }
  bool none() const { return before == 0 && behind == 0; }
};

/// Follows the edges between cells that were seen and cells that were not.
class Tracer {
 public:
  explicit Tracer(const cv::Mat& seen) : seen_(seen), traced_(seen.total()) {}

  /// Corners of a border in turn, in cells; empty when all have been given.
  std::vector<cv::Point> next() {
    for (; begin_.y < seen_.rows; begin_ = {0, begin_.y + 1}) {
      for (; begin_.x < seen_.cols; ++begin_.x) {
        if (is_seen(begin_) && !is_seen(begin_ - cv::Point(0, 1)) && !traced_[index(begin_)])
          return follow();
      }
    }
    return {};
  }

 private:
  bool is_seen(const cv::Point& cell) const {
    return cell.inside({0, 0, seen_.cols, seen_.rows}) && seen_.at<std::uint8_t>(cell) != 0;
  }
  std::size_t index(const cv::Point& cell) const {
    return static_cast<std::size_t>(cell.y) * seen_.cols + cell.x;
  }

  // From the first cell's upper edge on, with what was seen to the right of the way.
  std::vector<cv::Point> follow() {
    std::vector<cv::Point> corners;
    cv::Point at = begin_, step(1, 0);
    do {
      if (step.x > 0) traced_[index(at)] = true;
      at += step;
      // Of the four cells around, the two ahead.
      const cv::Point right(-step.y, step.x);
      const cv::Point ahead((step.x + right.x - 1) / 2, (step.y + right.y - 1) / 2);
      const cv::Point before = step;
      // Left first: cells that touch at a corner belong together.
      if (is_seen(at + ahead - right)) {
        step = -right;
      } else if (!is_seen(at + ahead)) {
        step = right;
      }
      if (step != before) corners.push_back(at);
    } while (at != begin_ || step != cv::Point(1, 0));
    return corners;
  }

  const cv::Mat& seen_;
  std::vector<bool> traced_;  ///< upper edges
  cv::Point begin_;
};

}  // namespace

Eigen::Vector2d SeenGround::in_cells(const Eigen::Vector2d& ground) const {
  return (ground - origin_) / cell_;
}

void SeenGround::add(std::span<const Eigen::Vector2d> footprint) {
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
    seen_ = cv::Mat(1, 1, CV_8UC1, cv::Scalar(0));
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

void SeenGround::make_room(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  while (true) {
    const Eigen::Vector2d first = in_cells(low), last = in_cells(high);
    const Lack x(first.x(), last.x(), seen_.cols), y(first.y(), last.y(), seen_.rows);
    if (x.none() && y.none()) return;
    if (!x.fits(seen_.cols) || !y.fits(seen_.rows)) {
      coarsen();
      continue;
    }
    cv::Mat wider;
    cv::copyMakeBorder(seen_, wider, static_cast<int>(y.before), static_cast<int>(y.behind),
                       static_cast<int>(x.before), static_cast<int>(x.behind), cv::BORDER_CONSTANT,
                       cv::Scalar(0));
    seen_ = wider;
    origin_ -= cell_ * Eigen::Vector2d(x.before, y.before);
  }
}

void SeenGround::coarsen() {
  cell_ *= 2;
  if (seen_.empty()) return;
  cv::copyMakeBorder(seen_, seen_, 0, seen_.rows % 2, 0, seen_.cols % 2, cv::BORDER_CONSTANT,
                     cv::Scalar(0));
  cv::Mat half(seen_.rows / 2, seen_.cols / 2, CV_8UC1);
  for (int y = 0; y < half.rows; ++y) {
    const auto *above = seen_.ptr<std::uint8_t>(2 * y), *below = seen_.ptr<std::uint8_t>(2 * y + 1);
    auto* to = half.ptr<std::uint8_t>(y);
    for (std::ptrdiff_t x = 0; x < half.cols; ++x)
      to[x] = above[2 * x] | above[2 * x + 1] | below[2 * x] | below[2 * x + 1];
  }
  seen_ = half;
}

std::vector<std::vector<Eigen::Vector2d>> SeenGround::outline() const {
  if (seen_.empty()) return {};
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  Tracer borders(seen_);
  for (auto corners = borders.next(); !corners.empty(); corners = borders.next()) {
    std::vector<cv::Point> simpler;
    constexpr double kWithin = 1;  // cell: a slanting border's steps
    cv::approxPolyDP(corners, simpler, kWithin, true);
    constexpr std::size_t kFewest = 3;
    if (simpler.size() < kFewest) simpler = std::move(corners);  // no wider than a cell
    std::vector<Eigen::Vector2d> polygon;
    polygon.reserve(simpler.size());
    for (const cv::Point& at : simpler)
      polygon.push_back(origin_ + cell_ * Eigen::Vector2d(at.x, at.y));
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

double SeenGround::area() const {
  return seen_.empty() ? 0 : cell_ * cell_ * cv::countNonZero(seen_);
}

}  // namespace nadir::coverage
