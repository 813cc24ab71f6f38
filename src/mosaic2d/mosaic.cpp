// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/mosaic2d/mosaic.hpp"

#include <cmath>

#include "blending.hpp"
#include "nadir/core/check.hpp"

namespace nadir::mosaic2d {
namespace {

constexpr int kSize = MosaicGrid::kTileSize;
constexpr std::size_t kMostImages = 1 << 16;  // owners are numbered in 16 bits

std::int32_t tile_of(int pixel) { return (pixel >= 0 ? pixel : pixel - kSize + 1) / kSize; }

cv::Rect tile_rect(std::int32_t row, std::int32_t column) {
  return {column * kSize, row * kSize, kSize, kSize};
}

}  // namespace

std::vector<std::shared_ptr<const Tile>> Mosaic::tiles() const {
  std::vector<std::shared_ptr<const Tile>> tiles;
  tiles.reserve(cells_.size());
  for (const auto& [index, cell] : cells_) tiles.push_back(cell.tile);
  return tiles;
}

cv::Point Mosaic::origin_of(const ProjectedImage& image) const {
  const double gsd = grid_.ground_sampling_distance;
  const double column = (image.world.c - grid_.world.c) / gsd;
  const double row = (grid_.world.f - image.world.f) / gsd;
  constexpr double kFarthest = 1 << 30;  // px; keeps sums of pixel numbers inside an int
  NADIR_CHECK(image.bgra.type() == CV_8UC4, image.image);
  NADIR_CHECK(std::abs(column) < kFarthest && std::abs(row) < kFarthest, column, row);
  NADIR_CHECK(std::abs(column - std::round(column)) < 0.01 &&
                  std::abs(row - std::round(row)) < 0.01 &&
                  std::abs(image.world.a - gsd) * image.bgra.cols < 0.01 * gsd,
              image.image, column, row, image.world.a, gsd);
  return {static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row))};
}

std::vector<std::shared_ptr<const Tile>> Mosaic::add(const ProjectedImage& image) {
  std::vector<std::shared_ptr<const Tile>> changed;
  const cv::Point origin = origin_of(image);
  const Outline seen = outline(image.bgra);
  if (!seen.centre) return changed;
  const cv::Point2d centre = *seen.centre + cv::Point2d(origin);
  for (int row = tile_of(origin.y); row <= tile_of(origin.y + image.bgra.rows - 1); ++row) {
    for (int column = tile_of(origin.x); column <= tile_of(origin.x + image.bgra.cols - 1);
         ++column) {
      const Index index{row, column};
      const auto [cell, is_new] = cells_.try_emplace(index);
      if (blend({image.bgra, seen.border}, origin, centre, index, cell->second)) {
        changed.push_back(cell->second.tile);
      } else if (is_new) {
        cells_.erase(cell);
      }
    }
  }
  return changed;
}

bool Mosaic::blend(const Patch& image, cv::Point origin, cv::Point2d centre, Index index,
                   Cell& cell) const {
  if (cell.centres.size() == kMostImages) return false;
  Tile tile{grid_.mosaic, index.second, index.first, {}};
  if (cell.tile) {
    tile.bgra = cell.tile->bgra.clone();
  } else {
    tile.bgra = cv::Mat::zeros(kSize, kSize, CV_8UC4);
    cell.owner = cv::Mat::zeros(kSize, kSize, CV_16UC1);
    cell.border = cv::Mat::zeros(kSize, kSize, CV_8UC1);
  }
  const cv::Rect whole = tile_rect(index.first, index.second);
  const cv::Rect common = whole & cv::Rect(origin, image.bgra.size());
  const Patch from{image.bgra(common - origin), image.border(common - origin)};
  const cv::Rect inside = common - whole.tl();
  Ground onto{tile.bgra(inside), cell.owner(inside), cell.border(inside)};
  cell.centres.push_back(centre);
  if (!blend_patch(from, std::move(onto), common.tl(), cell.centres)) {
    cell.centres.pop_back();
    return false;
  }
  cell.tile = std::make_shared<const Tile>(std::move(tile));
  return true;
}

cv::Vec3d Mosaic::gain_to_match(const ProjectedImage& image) const {
  const cv::Point origin = origin_of(image);
  const cv::Rect placed(origin, image.bgra.size());
  Overlap overlap;
  for (const auto& [index, cell] : cells_) {
    const cv::Rect whole = tile_rect(index.first, index.second);
    const cv::Rect common = whole & placed;
    if (common.empty()) continue;
    overlap.add(image.bgra(common - origin), cell.tile->bgra(common - whole.tl()));
  }
  return overlap.gain();
}

}  // namespace nadir::mosaic2d
