// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Mosaics made again from the projected images.
#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>

#include "nadir/image_io/decode.hpp"
#include "nadir/mosaic2d/corrected.hpp"
#include "nadir/mosaic2d/mosaic.hpp"
#include "products.hpp"
#include "projected_folder.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

cv::Mat read_projected(const path& name) {
  std::ifstream in = open_to_read(name);
  const Bytes file((std::istreambuf_iterator<char>(in)), {});
  return image_io::decode_bgra(file).image;
}

}  // namespace

bool is_moved(const Ledger& ledger) {
  return !ledger.corrections.empty() && !ledger.projected.empty();
}

MosaicTiles rebuilt_tiles(const path& dive, Ledger& ledger) {
  const bool moved = is_moved(ledger);
  if (moved) {
    for (auto& [number, grid] : ledger.mosaics) {
      if (ledger.mosaic_first_image.contains(number)) grid = mosaic2d::levelled(grid);
    }
  }
  MosaicTiles tiles;
  // One mosaic follows the other, so that one at a time is held.
  std::ranges::stable_sort(ledger.projected, std::less(),
                           [](const auto& p) { return p.file.mosaic; });
  std::optional<mosaic2d::Mosaic> mosaic;
  for (const auto& [file, submap, plane] : ledger.projected) {
    const auto grid = ledger.mosaics.find(file.mosaic);
    if (grid == ledger.mosaics.end()) continue;
    if (!mosaic || mosaic->grid().mosaic != file.mosaic) mosaic.emplace(grid->second);
    const cv::Mat bgra = read_projected(projected_name(dive, file.image));
    if (bgra.empty()) continue;
    ProjectedImage image{file.image, bgra, file.world};
    if (moved) image = mosaic2d::aligned(image, grid->second);
    if (image.bgra.empty()) continue;
    for (const auto& tile : mosaic->add(image)) tiles[place_of(*tile)] = tile;
  }
  if (moved) {
    std::erase_if(ledger.tiles, [&](const TilePlace& tile) {
      return ledger.mosaic_first_image.contains(tile.mosaic);
    });
    for (const auto& [place, tile] : tiles) ledger.tiles.insert(place);
  }
  return tiles;
}

std::vector<std::string> incomplete_mosaics(const Ledger& ledger) {
  std::vector<std::string> mosaics;
  for (const auto& [mosaic, unsaved] : ledger.unsaved) {
    if (!ledger.mosaic_first_image.contains(mosaic)) continue;
    mosaics.push_back("mosaic2d/mosaic-" + padded(mosaic, 3) + ".png: lacks " +
                      std::to_string(unsaved) + " of its images, whose files could not be saved");
  }
  return mosaics;
}

}  // namespace nadir::record
