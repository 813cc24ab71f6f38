// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/overviews.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace nadir::mosaic2d {
namespace {

constexpr int kSide = MosaicGrid::kTileSize / Overviews::kTiles;  // px of a tile in its overview

/// The overview that has a tile in this column or row; also of negative ones.
std::int32_t floored(std::int32_t tile) {
  return (tile >= 0 ? tile : tile - (Overviews::kTiles - 1)) / Overviews::kTiles;
}

cv::Mat small(const cv::Mat& bgra) {
  cv::Mat reduced, alpha;
  cv::extractChannel(bgra, alpha, 3);
  if (cv::countNonZero(alpha == 255) == static_cast<int>(alpha.total())) {  // most are
    cv::resize(bgra, reduced, {kSide, kSide}, 0, 0, cv::INTER_AREA);
    return reduced;
  }
  cv::Mat seen(bgra.size(), CV_32FC4, cv::Scalar::all(0)), all;
  bgra.convertTo(all, CV_32F);
  all.copyTo(seen, alpha);  // what was not seen has no part in the mean
  cv::resize(seen, seen, {kSide, kSide}, 0, 0, cv::INTER_AREA);
  seen.forEach<cv::Vec4f>([](cv::Vec4f& pixel, const int*) {
    if (const float share = pixel[3] / 255; share > 0) {
      for (int k = 0; k < 3; ++k) pixel[k] /= share;
    }
  });
  seen.convertTo(reduced, CV_8U);
  return reduced;
}

}  // namespace

void Overviews::add(const Tile& tile) {
  const std::int32_t column = floored(tile.column), row = floored(tile.row);
  const Place place(tile.mosaic, row, column);
  cv::Mat& overview = overviews_[place];
  if (overview.empty()) {
    overview = cv::Mat::zeros(MosaicGrid::kTileSize, MosaicGrid::kTileSize, CV_8UC4);
  }
  const cv::Rect part(kSide * (tile.column - kTiles * column), kSide * (tile.row - kTiles * row),
                      kSide, kSide);
  small(tile.bgra).copyTo(overview(part));
  changed_.insert(place);
}

std::vector<Tile> Overviews::take(std::size_t most) {
  std::vector<Tile> taken;
  while (taken.size() < most && !changed_.empty()) {
    // In turn, so that none waits for those that change all the time.
    auto next = changed_.upper_bound(last_);
    if (next == changed_.end()) next = changed_.begin();
    last_ = changed_.extract(next).value();
    const auto& [mosaic, row, column] = last_;
    taken.push_back({mosaic, column, row, overviews_.at(last_).clone()});
  }
  return taken;
}

}  // namespace nadir::mosaic2d
