// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "facts.hpp"

#include <algorithm>
#include <iterator>

#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/encode.hpp"

namespace nadir {
namespace {

using record::Is;

constexpr int kMostGridSide = 1 << 10;
constexpr auto kGridEffort = image_io::PngEffort::small;

}  // namespace

// Found by the archives through the namespace of their arguments, hence not in the unnamed one.
template <class Archive>
void fields(Archive& archive, Is<Rigid3> auto& pose) {
  archive(pose.translation);
  archive.raw(pose.rotation.coeffs().data(), 4 * sizeof(double));
}

template <class Archive>
void fields(Archive& archive, Is<ImagePose> auto& pose) {
  archive(pose.image, pose.time, pose.submap, pose.key_frame, pose.tie_points, pose.rms_px,
          pose.survey_from_camera, pose.sigma_position, pose.sigma_rotation);
}

template <class Archive>
void fields(Archive& archive, Is<DeadReckoned> auto& place) {
  archive(place.image, place.submap, place.survey_from_camera, place.sigma_position);
}

template <class Archive>
void fields(Archive& archive, Is<TiePoint> auto& point) {
  archive(point.id, point.x_in_survey, point.rgb, point.images, point.rms_px);
}

template <class Archive>
void fields(Archive& archive, Is<Health> auto& health) {
  archive(health.tie_points, health.by_quadrant, health.tracked_length, health.rms_px,
          health.sharpness, health.exposure, health.weaknesses);
}

template <class Archive>
void fields(Archive& archive, Is<ImageHealth> auto& later) {
  archive(later.image, later.health);
}

template <class Archive>
void fields(Archive& archive, Is<Plane> auto& plane) {
  archive(plane.normal, plane.offset, plane.centroid, plane.inliers, plane.inlier_ratio, plane.rms,
          plane.iterations);
}

template <class Archive>
void fields(Archive& archive, Is<WorldFile> auto& world) {
  archive(world.a, world.d, world.b, world.e, world.c, world.f);
}

template <class Archive>
void fields(Archive& archive, Is<MosaicGrid> auto& mosaic) {
  archive(mosaic.mosaic, mosaic.submap, mosaic.ground_sampling_distance, mosaic.world,
          mosaic.plane);
}

template <class Archive>
void fields(Archive& archive, Is<Alert> auto& alert) {
  archive(alert.time, alert.image, alert.kind, alert.message, alert.remedy);
}

template <class Archive>
void fields(Archive& archive, Is<Mark> auto& mark) {
  archive(mark.id, mark.time, mark.image, mark.position, mark.removed, mark.note);
}

template <class Archive>
void fields(Archive& archive, Is<Correction> auto& correction) {
  archive(correction.image, correction.submap, correction.corrected_from_live.scale,
          correction.corrected_from_live.rigid);
}

template <class Archive>
void fields(Archive& archive, Is<std::pair<std::uint32_t, Scale>> auto& scale) {
  archive(scale.first, scale.second.source, scale.second.sigma);
}

template <class Archive>
void fields(Archive& archive, Is<Join> auto& join) {
  archive(join.submap, join.to, join.image, join.seen_by);
}

template <class Archive>
void fields(Archive& archive, Is<Grid> auto& grid) {
  archive(grid.image, grid.submap, grid.survey_from_grid, grid.camera_in_survey, grid.max_range);
  int rows = grid.bgr.rows, columns = grid.bgr.cols;
  archive(rows, columns);
  record::Bytes png;
  if constexpr (!Archive::kReads) png = image_io::encode_png(grid.bgr, kGridEffort);
  archive(png);
  if constexpr (Archive::kReads) {
    const bool sensible = rows > 0 && columns > 0 && std::max(rows, columns) <= kMostGridSide;
    if (sensible && archive.pixels()) {
      grid.bgr = image_io::decode(png, columns, rows, 1, image_io::Colour::bgr).image;
    } else if (sensible) {
      grid.bgr = cv::Mat::zeros(rows, columns, CV_8UC3);
    }
    if (grid.bgr.empty()) archive.fail();
  }
}

namespace record {

template <class Archive>
void fields(Archive& archive, Is<WindowFacts> auto& window) {
  archive(window.submap, window.scale.source, window.scale.sigma, window.axes, window.uncertain,
          window.rms_px, window.tie_points, window.given_up);
}

template <class Archive>
void fields(Archive& archive, Is<ProjectedFile> auto& file) {
  archive(file.image, file.mosaic, file.spare, file.world, file.size, file.crc32);
}

template <class Archive>
void fields(Archive& archive, Is<TilePlace> auto& tile) {
  archive(tile.mosaic, tile.row, tile.column);
}

template <class Archive>
void fields(Archive& archive, Is<Facts> auto& facts) {
  archive(facts.of_shot, facts.image, facts.time, facts.name, facts.rejected, facts.dropped_before,
          facts.missed_before, facts.state, facts.submap, facts.poses, facts.lost,
          facts.dead_reckoned, facts.health, facts.later_health, facts.axes, facts.window,
          facts.plane, facts.grid, facts.mosaic, facts.projected, facts.tiles, facts.alerts,
          facts.corrections, facts.joins, facts.scales);
}

namespace {

template <class T>
Bytes encoded(const T& value) {
  Encoder archive;
  archive(value);
  return archive.take();
}

template <class T>
std::optional<T> decoded(std::span<const std::uint8_t> bytes, bool pixels = true) {
  T value;
  Decoder archive(bytes, pixels);
  archive(value);
  return archive.ended() ? std::optional(std::move(value)) : std::nullopt;
}

void append(std::vector<Alert>& to, const std::vector<Alert>& alerts) {
  to.insert(to.end(), alerts.begin(), alerts.end());
}

WindowFacts facts_of(const Window& window) {
  WindowFacts facts{window.submap, window.scale, window.axes,    window.uncertain,
                    window.rms_px, {},           window.given_up};
  std::ranges::copy_if(window.tie_points, std::back_inserter(facts.tie_points),
                       [](const TiePoint& point) { return point.x_in_survey.allFinite(); });
  return facts;
}

void add(const Shot& shot, Facts& facts) {
  facts.image = shot.image;
  facts.time = shot.time;
  facts.name = shot.name;
  facts.rejected = shot.frame == nullptr;
  facts.dropped_before = shot.dropped_before;
  facts.missed_before = shot.missed_before;
  append(facts.alerts, shot.alerts);
}

void add(const Orientation& orientation, Facts& facts) {
  facts.of_shot = orientation.shot != nullptr;
  if (facts.of_shot) add(*orientation.shot, facts);
  facts.state = orientation.state;
  facts.submap = orientation.submap;
  std::ranges::copy_if(orientation.poses, std::back_inserter(facts.poses),
                       [](const ImagePose& pose) { return pose.survey_from_camera.is_finite(); });
  facts.lost = orientation.lost;
  const auto& reckoned = orientation.dead_reckoned;
  if (reckoned && reckoned->survey_from_camera.is_finite()) facts.dead_reckoned = reckoned;
  facts.health = orientation.health;
  facts.later_health = orientation.later_health;
  facts.axes = orientation.axes;
  if (orientation.window) facts.window = facts_of(*orientation.window);
  append(facts.alerts, orientation.alerts);
}

void add(const MosaicUpdate& update, Facts& facts) {
  facts.mosaic = update.grid;
  for (const auto& tile : update.tiles) facts.tiles.push_back(place_of(*tile));
  append(facts.alerts, update.alerts);
}

void add(const Revision& revision, Facts& facts) {
  facts.corrections.insert(facts.corrections.end(), revision.corrections.begin(),
                           revision.corrections.end());
  facts.joins.insert(facts.joins.end(), revision.joins.begin(), revision.joins.end());
  facts.scales.insert(facts.scales.end(), revision.scales.begin(), revision.scales.end());
  append(facts.alerts, revision.alerts);
}

}  // namespace

TilePlace place_of(const Tile& tile) { return {tile.mosaic, tile.row, tile.column}; }

Facts facts_of(const Entry& entry) {
  NADIR_CHECK(entry.orientation);
  Facts facts;
  add(*entry.orientation, facts);
  if (entry.surface) {
    facts.plane = entry.surface->plane;
    append(facts.alerts, entry.surface->alerts);
  }
  if (entry.cloud) {
    facts.grid = entry.cloud->grid;
    append(facts.alerts, entry.cloud->alerts);
  }
  if (entry.mosaic) add(*entry.mosaic, facts);
  for (const auto& revision : entry.revisions) add(*revision, facts);
  return facts;
}

Bytes encode(const Facts& facts) { return encoded(facts); }
Bytes encode(const Alert& alert) { return encoded(alert); }
Bytes encode(const Mark& mark) { return encoded(mark); }

std::optional<Facts> decode_facts(std::span<const std::uint8_t> bytes, bool pixels) {
  return decoded<Facts>(bytes, pixels);
}

std::optional<Alert> decode_alert(std::span<const std::uint8_t> bytes) {
  return decoded<Alert>(bytes);
}

std::optional<Mark> decode_mark(std::span<const std::uint8_t> bytes) {
  auto mark = decoded<Mark>(bytes);
  return mark && mark->position.allFinite() ? mark : std::nullopt;
}

}  // namespace record
}  // namespace nadir
