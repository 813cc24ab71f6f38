// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The loose files of a dive, made from its ledger and journal (formats: docs of a dive folder).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "ledger.hpp"
#include "loose_file.hpp"

namespace nadir::record {

/// Newest version of each, in the order of the mosaics' rows.
using MosaicTiles = std::map<TilePlace, std::shared_ptr<const Tile>>;
/// By file name relative to the dive.
using Stamps = std::map<std::string, Stamp>;

struct Outcome {
  Stamps stamps;  ///< of all loose files, made or left alone
  std::vector<std::string> made;
  std::map<std::string, int> failed;  ///< -errno
  std::set<std::string> lost;         ///< mosaics of whose images none was saved
};

/// Makes every loose file but dive.json, except those in `whole`. Those in `changed` are kept
/// beside the new ones as NAME.changed.
Outcome make_products(Disk& disk, const path& dive, const Ledger& ledger, const MosaicTiles& tiles,
                      const Stamps& whole, const std::set<std::string>& changed);

/// Whether corrections moved projected images, so that mosaics are to be made of them again.
bool is_moved(const Ledger& ledger);

/// From the projected images in the folder: as they were made at first, or where corrections have
/// moved them; the ledger's mosaics and tiles are then those. Mosaics without projected images are
/// left out.
MosaicTiles rebuilt_tiles(const path& dive, Ledger& ledger);

/// Of the mosaics that can only be made again without some of their images, whose files could not
/// be saved.
std::vector<std::string> incomplete_mosaics(const Ledger& ledger);

/// Covered by the mosaics, in square survey units; ground in two of them counts twice.
double covered_area(const Ledger& ledger, const MosaicTiles& tiles);

/// dive.json; rates as given.
nlohmann::json summary(const Ledger& ledger, double area, const Stamps& stamps,
                       const nlohmann::json& rates);
int write_summary(Disk& disk, const path& dive, const nlohmann::json& summary);
/// Spare and temporary files that no longer serve.
void remove_leftovers(Disk& disk, const path& dive);

// One function a format; false when the file could not be written whole.
bool write_trajectory(LooseFile& file, const Ledger& ledger,
                      std::optional<ImagePose> ImageFacts::*which);
/// Of a ledger with a grid: where the final poses are on it and on the earth.
bool write_track(LooseFile& file, const Ledger& ledger);
bool write_sparse(LooseFile& file, const Ledger& ledger, const path& dive);
bool write_projection3d(LooseFile& file, const Ledger& ledger, const path& dive);
bool write_alerts(LooseFile& file, const Ledger& ledger);
bool write_marks(LooseFile& file, const Ledger& ledger);
/// Of a ledger with a grid. RFC 7946.
bool write_marks_on_earth(LooseFile& file, const Ledger& ledger);
bool write_health(LooseFile& file, const Ledger& ledger);

/// One mosaic's tiles as a north-up raster.
struct MosaicRaster {
  MosaicGrid grid;
  std::int32_t first_column = 0, first_row = 0, columns = 0, rows = 0;  ///< tiles
  std::uint64_t seen_px = 0;                                            ///< with alpha

  WorldFile world() const;  ///< of the raster's pixel (0, 0)
};
std::map<std::uint32_t, MosaicRaster> rasters(const Ledger& ledger, const MosaicTiles& tiles);
bool write_mosaic(LooseFile& file, const MosaicRaster& raster, const MosaicTiles& tiles);
/// GDAL's PAM file: UTM, or a local engineering coordinate system and whether it is metric.
std::string auxiliary_xml(const Ledger& ledger);

/// "metres" or "unscaled": what a survey unit is.
std::string survey_unit(const Scale& scale);
/// The unit, where the scale is from and how certain it is.
std::string scale_text(const Scale& scale);

}  // namespace nadir::record
