// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "facts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

// Of coordinates; a map that says it is larger is wrong.
constexpr double kFarthest = 1e9;

bool is_sound(double number) { return std::abs(number) < kFarthest; }
template <class Derived>
bool is_sound(const Eigen::DenseBase<Derived>& numbers) {
  return numbers.derived().allFinite() && numbers.derived().cwiseAbs().maxCoeff() < kFarthest;
}
bool is_unit(double length) { return std::abs(length - 1) < 1e-3; }
bool is_sound(const Rigid3& pose) {
  return is_sound(pose.translation) && is_unit(pose.rotation.norm());
}
bool is_sound(const ImagePose& pose) {
  return is_sound(pose.survey_from_camera) && is_sound(pose.rms_px) &&
         is_sound(pose.sigma_position) && is_sound(pose.sigma_rotation);
}
bool is_sound(const DeadReckoned& place) {
  return is_sound(place.survey_from_camera) && is_sound(place.sigma_position);
}
bool is_sound(const TiePoint& point) { return is_sound(point.x_in_survey); }
bool is_sound(const Scale& scale) { return is_sound(scale.sigma); }
bool is_sound(const std::pair<std::uint32_t, Scale>& scale) { return is_sound(scale.second); }
bool is_sound(const Plane& plane) {
  return is_unit(plane.normal.norm()) && is_sound(plane.offset) && is_sound(plane.centroid);
}
bool is_sound(const WorldFile& world) {
  const Eigen::Matrix<double, 6, 1> numbers{world.a, world.d, world.b, world.e, world.c, world.f};
  return is_sound(numbers) && world.a * world.e != world.b * world.d;
}
bool is_sound(const ProjectedFile& file) { return is_sound(file.world); }
bool is_sound(const MosaicGrid& mosaic) {
  const double sampling = mosaic.ground_sampling_distance;
  return sampling > 0 && is_sound(sampling) && is_sound(mosaic.world) && is_sound(mosaic.plane) &&
         mosaic.plane.normal.z() != 0;
}
bool is_sound(const Grid& grid) {
  return is_sound(grid.survey_from_grid) && is_sound(grid.camera_in_survey) &&
         is_sound(grid.max_range);
}
bool is_sound(const Correction& correction) {
  const auto& [scale, rigid] = correction.corrected_from_live;
  return scale > 0 && is_sound(scale) && is_sound(rigid);
}

// The later one lies in the frame of the earlier; else they could lead in a circle.
bool is_sound(const Join& join) { return join.to < join.submap; }

template <class T>
void keep_sound(std::vector<T>& values) {
  std::erase_if(values, [](const T& value) { return !is_sound(value); });
}
template <class T>
void keep_sound(std::optional<T>& value) {
  if (value && !is_sound(*value)) value.reset();
}

void keep_sound(WindowFacts& window) {
  keep_sound(window.tie_points);
  if (!is_sound(window.scale)) window.scale = {};
  if (!is_sound(window.rms_px)) window.rms_px = 0;
}

Facts sound(Facts facts) {
  keep_sound(facts.poses);
  keep_sound(facts.dead_reckoned);
  if (facts.window) keep_sound(*facts.window);
  keep_sound(facts.plane);
  keep_sound(facts.grid);
  keep_sound(facts.mosaic);
  keep_sound(facts.projected);
  if (!facts.mosaic) facts.tiles.clear();
  const std::size_t corrections = facts.corrections.size();
  keep_sound(facts.corrections);
  if (facts.corrections.size() < corrections) facts.joins.clear();  // they rest on them
  keep_sound(facts.joins);
  keep_sound(facts.scales);
  return facts;
}

void append(std::vector<Alert>& to, const std::vector<Alert>& alerts) {
  to.insert(to.end(), alerts.begin(), alerts.end());
}

WindowFacts facts_of(const Window& window) {
  return {window.submap, window.scale,      window.axes,    window.uncertain,
          window.rms_px, window.tie_points, window.given_up};
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
  facts.poses = orientation.poses;
  facts.lost = orientation.lost;
  facts.dead_reckoned = orientation.dead_reckoned;
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
  return sound(std::move(facts));
}

Bytes encode(const Facts& facts) { return encoded(facts); }
Bytes encode(const Alert& alert) { return encoded(alert); }
Bytes encode(const Mark& mark) { return encoded(mark); }

std::optional<Facts> decode_facts(std::span<const std::uint8_t> bytes, bool pixels) {
  auto facts = decoded<Facts>(bytes, pixels);
  if (facts) facts = sound(std::move(*facts));
  return facts;
}

std::optional<Alert> decode_alert(std::span<const std::uint8_t> bytes) {
  return decoded<Alert>(bytes);
}

std::optional<Mark> decode_mark(std::span<const std::uint8_t> bytes) {
  auto mark = decoded<Mark>(bytes);
  return mark && is_sound(mark->position) ? mark : std::nullopt;
}

}  // namespace record
}  // namespace nadir
