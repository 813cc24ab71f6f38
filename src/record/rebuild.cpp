// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Mosaics made again from the projected images.
#include <fstream>
#include <iterator>

#include "nadir/image_io/decode.hpp"
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

MosaicTiles rebuilt_tiles(const path& dive, const Ledger& ledger) {
  std::map<std::uint32_t, mosaic2d::Mosaic> mosaics;
  for (const auto& [number, grid] : ledger.mosaics) mosaics.try_emplace(number, grid);
  MosaicTiles tiles;
  for (const ProjectedFile& file : ledger.projected) {
    const auto mosaic = mosaics.find(file.mosaic);
    if (mosaic == mosaics.end()) continue;
    const cv::Mat bgra = read_projected(projected_name(dive, file.image));
    if (bgra.empty()) continue;
    for (const auto& tile : mosaic->second.add({file.image, bgra, file.world})) {
      tiles[place_of(*tile)] = tile;
    }
  }
  return tiles;
}

}  // namespace nadir::record
