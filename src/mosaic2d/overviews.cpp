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
  cv::Mat seen(bgra.size(), CV_32FC4, cv::Scalar::all(0)), alpha, all;
  cv::extractChannel(bgra, alpha, 3);
  bgra.convertTo(all, CV_32F);
  all.copyTo(seen, alpha);  // what was not seen has no part in the mean
  cv::resize(seen, seen, {kSide, kSide}, 0, 0, cv::INTER_AREA);
  seen.forEach<cv::Vec4f>([](cv::Vec4f& pixel, const int*) {
    if (const float share = pixel[3] / 255; share > 0) {
      for (int k = 0; k < 3; ++k) pixel[k] /= share;
    }
  });
  cv::Mat small;
  seen.convertTo(small, CV_8U);
  return small;
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
    const Place place = changed_.extract(changed_.begin()).value();
    const auto& [mosaic, row, column] = place;
    taken.push_back({mosaic, column, row, overviews_.at(place)});
  }
  return taken;
}

}  // namespace nadir::mosaic2d
