// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// dive.json.
#include <algorithm>

#include "products.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

json counts_json(const Ledger& ledger) {
  const ImageCounts counts = ledger.counts();
  return {{"captured", counts.captured},
          {"oriented", counts.oriented},
          {"lost", counts.lost},
          {"dropped",
           {{"image_rejected", counts.image_rejected},
            {"queue_full", counts.queue_full},
            {"storage", counts.storage}}},
          {"tie_points", ledger.tie_points.size()},
          {"windows", ledger.windows},
          {"planes", ledger.planes},
          {"mosaic_tiles", ledger.tiles.size()}};
}

struct Range {
  std::uint64_t first, last;
};

json submaps_json(const Ledger& ledger) {
  std::map<std::uint32_t, Range> ranges;
  for (const auto& [number, image] : ledger.images) {
    if (!image.final) continue;
    ranges.try_emplace(image.final->submap, Range{number, number}).first->second.last = number;
  }
  json submaps = json::array();
  for (const auto& [id, range] : ranges) {
    const auto joined = ledger.joined.find(id);
    submaps.push_back({{"id", id},
                       {"first_image", range.first},
                       {"last_image", range.last},
                       {"joined", joined == ledger.joined.end() ? json() : json(joined->second)},
                       {"uncertain", ledger.uncertain.contains(id)}});
  }
  return submaps;
}

json files_json(const Stamps& stamps) {
  json files = json::object();
  for (const auto& [name, stamp] : stamps) {
    files[name] = {{"bytes", stamp.size}, {"crc32", stamp.crc32}};
  }
  return files;
}

}  // namespace

double covered_area(const Ledger& ledger, const MosaicTiles& tiles) {
  double area = 0;
  for (const auto& [number, raster] : rasters(ledger, tiles)) {
    const double side = raster.grid.ground_sampling_distance;
    area += static_cast<double>(raster.seen_px) * side * side;
  }
  return area;
}

json summary(const Ledger& ledger, double area, const Stamps& stamps, const json& rates) {
  json dive = ledger.about;
  const Scale scale = ledger.scale();
  const bool metric = scale.source != ScaleSource::none;
  dive["counts"] = counts_json(ledger);
  dive["submaps"] = submaps_json(ledger);
  dive["scale"] = {{"source", to_string(scale.source)},
                   {"sigma", metric ? json(scale.sigma) : json()}};
  dive["survey_unit"] = survey_unit(scale);
  dive["survey_axes"] = to_string(ledger.axes);
  dive["area_m2"] = metric ? json(area) : json();
  dive["area_survey_units"] = area;
  dive["drift"] = nullptr;
  dive["rates"] = rates;
  dive["cut_off"] = !ledger.ended;
  dive["missing_records"] = ledger.missing_records;
  dive["files"] = files_json(stamps);
  return dive;
}

}  // namespace nadir::record
