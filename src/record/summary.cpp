// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// dive.json.
#include <algorithm>
#include <cmath>

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
            {"camera", counts.camera},
            {"storage", counts.storage}}},
          {"tie_points", ledger.tie_points.size()},
          {"windows", ledger.windows},
          {"planes", ledger.planes},
          {"mosaic_tiles", ledger.tiles.size()}};
}

json scale_json(const Scale& scale) {
  const bool known = scale.sigma > 0;
  return {{"source", to_string(scale.source)}, {"sigma", known ? json(scale.sigma) : json()}};
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
    const auto scale = ledger.scales.find(id);
    submaps.push_back(
        {{"id", id},
         {"first_image", range.first},
         {"last_image", range.last},
         {"joined", joined == ledger.joined.end() ? json() : json(joined->second)},
         {"uncertain", ledger.uncertain.contains(id)},
         {"scale", scale_json(scale == ledger.scales.end() ? Scale() : scale->second)}});
  }
  return submaps;
}

// What odometry may have gone astray along each sub-map, before any revisit: the errors from image
// to image add up, and those of direction grow with the way that is still ahead.
json drift_json(const Ledger& ledger) {
  std::map<std::uint32_t, std::vector<const ImagePose*>> by_submap;
  for (const auto& [number, image] : ledger.images) {
    if (image.final) by_submap[image.final->submap].push_back(&*image.final);
  }
  json drifts = json::array();
  for (const auto& [submap, poses] : by_submap) {
    constexpr double kSideways = 2.0 / 3;  // of a rotation's variance, about axes across the way
    const Eigen::Vector3d end = poses.back()->survey_from_camera.translation;
    double variance = 0, path = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const ImagePose& pose = *poses[i];
      const Eigen::Vector3d& here = pose.survey_from_camera.translation;
      path += (here - poses[i - 1]->survey_from_camera.translation).norm();
      if (!pose.key_frame) continue;
      variance += pose.sigma_position * pose.sigma_position + kSideways * pose.sigma_rotation *
                                                                  pose.sigma_rotation *
                                                                  (end - here).squaredNorm();
    }
    if (!(variance > 0)) continue;
    const double sigma = std::sqrt(variance);
    drifts.push_back({{"submap", submap},
                      {"path_survey_units", path},
                      {"sigma_survey_units", sigma},
                      {"sigma_percent", 100 * sigma / path}});
  }
  return drifts;
}

// Images without a pose: where they may have been taken.
json dead_reckoned_json(const Ledger& ledger) {
  json places = json::array();
  for (const auto& [number, image] : ledger.images) {
    if (image.final || !image.dead_reckoned) continue;
    const auto& [rotation, position] = image.dead_reckoned->survey_from_camera;
    places.push_back({{"image", number},
                      {"time_s", seconds(image.time)},
                      {"submap", image.dead_reckoned->submap},
                      {"position_survey_units", {position.x(), position.y(), position.z()}},
                      {"rotation_xyzw", {rotation.x(), rotation.y(), rotation.z(), rotation.w()}},
                      {"sigma_survey_units", image.dead_reckoned->sigma_position}});
  }
  return places;
}

// How many images are weak, by cause.
json weak_images_json(const Ledger& ledger) {
  json counts = json::object();
  for (const Weakness weakness : kWeaknesses) {
    counts[std::string(to_string(weakness))] =
        std::ranges::count_if(ledger.images, [&](const auto& image) {
          return image.second.recorded && image.second.health.has(weakness);
        });
  }
  return counts;
}

// Where the survey is on the earth, or why its files are not.
json origin_json(const Ledger& ledger) {
  json origin = ledger.about["origin"];
  origin["placed"] = ledger.grid.has_value();
  if (!ledger.grid) {
    origin["reason"] = ledger.axes == SurveyAxes::attitude
                           ? "the survey has no scale: its unit is no metre"
                           : "the survey's axes are not by an AHRS that can be relied on";
    return origin;
  }
  const reference::UtmGrid& grid = *ledger.grid;
  const Eigen::Vector2d place = grid(Eigen::Vector2d(0, 0));
  origin["epsg"] = grid.epsg();
  origin["utm_zone"] = std::to_string(grid.zone()) + (grid.is_north() ? 'N' : 'S');
  origin["easting_m"] = place.x();
  origin["northing_m"] = place.y();
  origin["convergence_deg"] = grid.convergence() * 180 / M_PI;
  origin["scale_factor"] = grid.scale();
  return origin;
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
  dive["scale"] = scale_json(scale);
  dive["survey_unit"] = survey_unit(scale);
  dive["survey_axes"] = to_string(ledger.axes);
  if (ledger.origin) dive["origin"] = origin_json(ledger);
  dive["area_m2"] = metric ? json(area) : json();
  dive["area_survey_units"] = area;
  dive["drift"] = drift_json(ledger);
  dive["weak_images"] = weak_images_json(ledger);
  dive["dead_reckoned"] = dead_reckoned_json(ledger);
  dive["rates"] = rates;
  dive["cut_off"] = !ledger.ended;
  dive["missing_records"] = ledger.missing_records;
  dive["files"] = files_json(stamps);
  return dive;
}

}  // namespace nadir::record
