// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "gaps.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace nadir::coverage {
namespace {

// A circle of this radius fits into a gap, and it has so many cells; less is noise between
// footprints that are a hand's breadth apart.
constexpr double kLeastRadius = 2;  // cells
constexpr int kLeastCells = 16;
constexpr double kWellInside = 0.7;  // of the largest distance from the rim

struct Region {
  int blocks = 0, cells = 0;
  float depth = 0;  ///< largest distance from the rim, blocks
  cv::Point2d sum;
  double nearest = 0;  ///< of the centre to the middle, squared
  cv::Point centre{-1, -1};
};

template <class Visit>
void for_regions(const cv::Mat1i& labels, std::vector<Region>& regions, Visit visit) {
  for (int y = 0; y < labels.rows; ++y) {
    const int* line = labels[y];
    for (int x = 0; x < labels.cols; ++x) {
      if (line[x] != 0) visit(regions[static_cast<std::size_t>(line[x])], cv::Point(x, y));
    }
  }
}

std::vector<Region> regions_of(const cv::Mat1b& gap, const cv::Mat1w& missing) {
  cv::Mat1i labels;
  std::vector<Region> regions(static_cast<std::size_t>(cv::connectedComponents(gap, labels, 8)));
  cv::Mat1f depth;
  cv::distanceTransform(gap, depth, cv::DIST_L2, cv::DIST_MASK_3);
  for_regions(labels, regions, [&](Region& region, const cv::Point& at) {
    ++region.blocks;
    region.cells += missing(at);
    region.sum += cv::Point2d(at);
    region.depth = std::max(region.depth, depth(at));
  });
  for_regions(labels, regions, [&](Region& region, const cv::Point& at) {
    if (depth(at) < kWellInside * region.depth) return;
    const cv::Point2d off = cv::Point2d(at) - region.sum / region.blocks;
    const double distance = off.dot(off);
    if (region.centre.x >= 0 && distance >= region.nearest) return;
    region.nearest = distance;
    region.centre = at;
  });
  return regions;
}

}  // namespace

std::vector<GapInBlocks> gaps_in(const cv::Mat1w& missing, int cells_a_side) {
  const int half_a_block = (cells_a_side * cells_a_side + 1) / 2;
  // A rim of nothing, so that what ends with the raster ends there.
  cv::Mat1w framed;
  cv::copyMakeBorder(missing, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  const cv::Mat1b gap(framed >= half_a_block);
  const cv::Rect box = cv::boundingRect(gap);
  if (box.empty()) return {};
  const cv::Rect around(box.x - 1, box.y - 1, box.width + 2, box.height + 2);
  std::vector<GapInBlocks> gaps;
  for (const Region& region : regions_of(gap(around), framed(around))) {
    const bool is_noise =
        region.cells < kLeastCells || double{region.depth} * cells_a_side < kLeastRadius;
    if (region.blocks == 0 || is_noise) continue;
    gaps.push_back({region.centre + around.tl() - cv::Point(1, 1), region.cells});
  }
  return gaps;
}

}  // namespace nadir::coverage
