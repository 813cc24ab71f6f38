// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "products.hpp"

#include <algorithm>
#include <functional>

#include "nadir/core/entries.hpp"
#include "projected_folder.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

using Write = std::function<bool(LooseFile&)>;

std::map<std::string, Write> tables(const Ledger& ledger, const path& dive) {
  std::map<std::string, Write> made{
      {"alerts.jsonl", [&](LooseFile& file) { return write_alerts(file, ledger); }},
      {"health.csv", [&](LooseFile& file) { return write_health(file, ledger); }},
      {"projection3d.ply", [&](LooseFile& file) { return write_projection3d(file, ledger, dive); }},
      {"sparse.ply", [&](LooseFile& file) { return write_sparse(file, ledger, dive); }},
      {"trajectory.tum",
       [&](LooseFile& file) { return write_trajectory(file, ledger, &ImageFacts::final); }},
      {"trajectory_live.tum",
       [&](LooseFile& file) { return write_trajectory(file, ledger, &ImageFacts::live); }},
  };
  if (!ledger.marks.empty()) {
    made["marks.jsonl"] = [&](LooseFile& file) { return write_marks(file, ledger); };
  }
  if (!ledger.marks.empty() && ledger.grid) {
    made["marks.geojson"] = [&](LooseFile& file) { return write_marks_on_earth(file, ledger); };
  }
  if (ledger.grid) made["track.csv"] = [&](LooseFile& file) { return write_track(file, ledger); };
  return made;
}

std::string mosaic_name(std::uint32_t number) { return "mosaic2d/mosaic-" + padded(number, 3); }

void add_mosaic(const MosaicRaster& raster, const Ledger& ledger, const MosaicTiles& tiles,
                std::map<std::string, Write>& products) {
  const std::string name = mosaic_name(raster.grid.mosaic);
  products[name + ".png"] = [&](LooseFile& file) { return write_mosaic(file, raster, tiles); };
  products[name + ".pgw"] = [&](LooseFile& file) {
    return file.write(text_of(raster.world(), ledger.grid));
  };
  products[auxiliary_name(name + ".png")] = [&](LooseFile& file) {
    return file.write(auxiliary_xml(ledger));
  };
}

void make(Disk& disk, const path& dive, const std::string& name, const Write& write,
          bool keep_changed, Outcome& outcome) {
  LooseFile file(disk, dive / name);
  const bool written = write(file);
  if (written && keep_changed) rename_file(disk, dive / name, dive / (name + ".changed"));
  const int error = written ? file.commit() : file.abandon();
  if (error == 0) {
    outcome.made.push_back(name);
    outcome.stamps[name] = file.stamp();
  } else {
    outcome.failed[name] = error;
  }
}

// A mosaic's place without its pixels is no product.
void withdraw_torn(Disk& disk, const path& dive, std::uint32_t number, Outcome& outcome) {
  const std::string name = mosaic_name(number);
  if (!outcome.failed.contains(name + ".png")) return;
  for (const char* suffix : {".pgw", ".png.aux.xml"}) {
    if (outcome.stamps.erase(name + suffix) > 0) disk.remove(dive / (name + suffix));
    std::erase(outcome.made, name + suffix);
  }
}

}  // namespace

Outcome make_products(Disk& disk, const path& dive, const Ledger& ledger, const MosaicTiles& tiles,
                      const Stamps& whole, const std::set<std::string>& changed) {
  std::map<std::string, Write> products = tables(ledger, dive);
  const auto mosaics = rasters(ledger, tiles);
  for (const auto& [number, raster] : mosaics) add_mosaic(raster, ledger, tiles, products);
  // An empty folder is easily lost on the way; what cannot be made in it says so itself.
  std::error_code error;
  if (!mosaics.empty() && !std::filesystem::exists(dive / "mosaic2d", error)) {
    disk.make_directory(dive / "mosaic2d");
  }
  Outcome outcome;
  outcome.stamps = whole;
  for (const auto& [name, write] : products) {
    if (!whole.contains(name)) make(disk, dive, name, write, changed.contains(name), outcome);
  }
  for (const auto& [number, raster] : mosaics) withdraw_torn(disk, dive, number, outcome);
  for (const TilePlace& tile : ledger.tiles) {
    const std::string name = mosaic_name(tile.mosaic) + ".png";
    if (!mosaics.contains(tile.mosaic) && !whole.contains(name)) outcome.lost.insert(name);
  }
  return outcome;
}

int write_summary(Disk& disk, const path& dive, const nlohmann::json& summary) {
  // All that dive.json vouches for comes first, projected images' names and world files too.
  if (const int error = sync_file_system(disk, dive); error != 0) return error;
  LooseFile file(disk, dive / "dive.json");
  file.write(summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
  const int error = file.commit();
  return error != 0 ? error : sync_directory(disk, dive);
}

void remove_leftovers(Disk& disk, const path& dive) {
  for (const path& folder : {dive, dive / "projected", dive / "mosaic2d"}) {
    std::vector<path> leftovers = entries_of(folder);
    std::erase_if(leftovers,
                  [](const path& name) { return !is_spare(name) && !is_temporary(name); });
    std::ranges::sort(leftovers);
    for (const path& name : leftovers) disk.remove(name);
  }
}

std::string survey_unit(const Scale& scale) {
  return scale.source == ScaleSource::none ? "unscaled" : "metres";
}

std::string scale_text(const Scale& scale) {
  if (scale.source == ScaleSource::none) return survey_unit(scale);
  std::string text = survey_unit(scale) + ", scale from " + std::string(in_words(scale.source));
  if (scale.sigma > 0) text += ", sigma " + fixed(100 * scale.sigma, 3) + " %";
  return text;
}

}  // namespace nadir::record
