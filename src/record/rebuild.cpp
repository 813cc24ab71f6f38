// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Mosaics made again from the projected images.
#include <fstream>
#include <iterator>

#include "nadir/image_io/decode.hpp"
#include "nadir/mosaic2d/corrected.hpp"
#include "nadir/mosaic2d/mosaic.hpp"
#include "products.hpp"
#include "projected_folder.hpp"

namespace nadir::record {
namespace {

cv::Mat read_projected(const path& name) {
  std::ifstream in(name, std::ios::binary);
  const Bytes file((std::istreambuf_iterator<char>(in)), {});
  return image_io::decode_bgra(file).image;
}

}  // namespace

MosaicTiles rebuilt_tiles(const path& dive, Ledger& ledger) {
  const bool moved = !ledger.corrections.empty();
  std::map<std::uint32_t, mosaic2d::Mosaic> mosaics;
  for (auto& [number, grid] : ledger.mosaics) {
    if (moved) grid = mosaic2d::levelled(grid);
    mosaics.try_emplace(number, grid);
  }
  MosaicTiles tiles;
  for (const auto& [file, submap, plane] : ledger.projected) {
    const auto mosaic = mosaics.find(file.mosaic);
    if (mosaic == mosaics.end()) continue;
    const cv::Mat bgra = read_projected(projected_name(dive, file.image));
    if (bgra.empty()) continue;
    ProjectedImage image{file.image, bgra, file.world};
    if (moved) image = mosaic2d::aligned(image, mosaic->second.grid());
    for (const auto& tile : mosaic->second.add(image)) tiles[place_of(*tile)] = tile;
  }
  if (moved) {
    ledger.tiles.clear();
    for (const auto& [place, tile] : tiles) ledger.tiles.insert(place);
  }
  return tiles;
}

}  // namespace nadir::record
