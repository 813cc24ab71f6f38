// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/check.hpp"
#include "nadir/wire/records.hpp"
#include "writer.hpp"

namespace nadir::wire {
namespace {

constexpr int kPlaceBits = 20;  // of a tile's column and of its row

/// A record's key: its type, then 56 bits that tell it from its like.
std::uint64_t make_key(RecordType type, std::uint64_t which = 0) {
  return (std::uint64_t{static_cast<std::uint8_t>(type)} << 56) | (which & ((1ULL << 56) - 1));
}

template <int size>
void put(Writer& to, const Eigen::Matrix<double, size, 1>& vector) {
  for (const double value : vector) {
    to.finite(value);
  }
}

/// Of a tile that shares its key with none within half a million either way.
std::uint64_t place(std::int32_t column, std::int32_t row) {
  constexpr std::int32_t kHalf = 1 << (kPlaceBits - 1);
  const auto side = [](std::int32_t index) {
    NADIR_CHECK(index >= -kHalf && index < kHalf, index);
    return static_cast<std::uint64_t>(std::int64_t{index} + kHalf);
  };
  return (side(column) << kPlaceBits) | side(row);
}

}  // namespace

PlaneGrid plane_grid(const Grid& grid) {
  return {.image = grid.image,
          .submap = grid.submap,
          .columns = static_cast<std::uint16_t>(grid.bgr.cols),
          .rows = static_cast<std::uint16_t>(grid.bgr.rows),
          .survey_from_grid = grid.survey_from_grid,
          .camera_in_survey = grid.camera_in_survey,
          .max_range = grid.max_range};
}

Bytes encode(const State& state) {
  Writer to(RecordType::state);
  to.choice(state.tracking).choice(state.axes).flag(state.finished).choice(state.scale.source);
  to.number(state.submap).number(state.image).number(state.time);
  to.finite(state.scale.sigma).finite(state.rate_hz);
  to.number(state.captured).number(state.oriented).number(state.lost).number(state.dropped);
  to.number(state.tie_points).number(state.windows).number(state.planes);
  to.number(state.mosaic_tiles).number(state.images_total);
  return to.text(state.input).finish();
}

Bytes encode(const AlertRecord& record) {
  const Alert& alert = record.alert;
  Writer to(RecordType::alert);
  to.number(record.id).number(alert.time).number(alert.image.value_or(0));
  to.flag(alert.image.has_value()).text(to_string(alert.kind));
  return to.text(alert.message).text(alert.remedy).finish();
}

Bytes encode(const CameraInfo& camera) {
  Writer to(RecordType::camera);
  to.number(camera.width).number(camera.height);
  return to.finite(camera.fx).finite(camera.fy).finite(camera.cx).finite(camera.cy).finish();
}

Bytes encode(const ImagePose& pose) {
  Writer to(RecordType::pose);
  to.number(pose.image).number(pose.time);
  put(to, pose.survey_from_camera.translation);
  for (const double value : pose.survey_from_camera.rotation.coeffs()) {
    to.finite(value);
  }
  to.number(pose.submap).number(pose.tie_points).finite<float>(pose.rms_px);
  to.finite<float>(pose.sigma_position);
  return to.flag(pose.key_frame).finish();
}

Bytes encode(const TiePoints& points) {
  Writer to(RecordType::tie_points);
  to.number(points.block);
  put(to, points.origin);
  for (const TiePoints::Point& point : points.points) {
    for (const float value : point.offset) {
      to.finite<float>(value);
    }
  }
  for (const TiePoints::Point& point : points.points) {
    to.number(point.index);
  }
  for (const TiePoints::Point& point : points.points) {
    to.number(point.rgb);
  }
  return to.finish();
}

Bytes encode(const PlaneGrid& grid) {
  Writer to(RecordType::plane_grid);
  to.number(grid.image).number(grid.submap).number(grid.columns).number(grid.rows);
  for (const auto& row : grid.survey_from_grid.rowwise()) {
    put<3>(to, row.transpose());
  }
  put(to, grid.camera_in_survey);
  return to.finite(grid.max_range).finish();
}

Bytes encode(const PlaneColour& colour) {
  return Writer(RecordType::plane_colour).number(colour.image).blob(colour.jpeg).finish();
}

Bytes encode(const MosaicGrid& mosaic) {
  Writer to(RecordType::mosaic);
  to.number(mosaic.mosaic).number(mosaic.submap).finite(mosaic.ground_sampling_distance);
  const WorldFile& world = mosaic.world;
  to.finite(world.a).finite(world.d).finite(world.b).finite(world.e);
  to.finite(world.c).finite(world.f);
  put(to, mosaic.plane.normal);
  return to.finite(mosaic.plane.offset).finish();
}

namespace {
template <class Tile>
Bytes encode_tile(RecordType type, const Tile& tile) {
  Writer to(type);
  to.number(tile.mosaic).number(tile.column).number(tile.row);
  return to.blob(tile.jpeg).blob(tile.mask_png).finish();
}
}  // namespace

Bytes encode(const MosaicTile& tile) { return encode_tile(RecordType::mosaic_tile, tile); }

Bytes encode(const MosaicOverview& overview) {
  return encode_tile(RecordType::mosaic_overview, overview);
}

Bytes encode(const LiveImage& image) {
  Writer to(RecordType::live_image);
  to.number(image.image).number(image.time).blob(image.jpeg);
  to.number(static_cast<std::uint16_t>(image.tie_points.size()));
  for (const auto& place : image.tie_points) to.number(place);
  return to.finish();
}

Bytes encode(const Statistics& statistics) {
  Writer to(RecordType::statistics);
  to.number(static_cast<std::uint8_t>(statistics.stages.size()));
  for (const StageStats& stage : statistics.stages) {
    to.text(stage.stage).finite(stage.rate_in_hz).finite(stage.rate_out_hz);
    to.number(stage.processed).number(stage.dropped).number(stage.depth);
    to.finite(stage.last_ms).finite(stage.p95_ms);
  }
  return to.finish();
}

Bytes encode(const Check& check) {
  Writer to(RecordType::check);
  to.number(static_cast<std::uint8_t>(check.findings.size()));
  for (const Finding& finding : check.findings)
    to.choice(finding.verdict).text(finding.item).text(finding.found).text(finding.remedy);
  return to.finish();
}

Bytes encode(const Measures& measures) {
  Writer to(RecordType::measures);
  to.number(static_cast<std::uint8_t>(measures.measures.size()));
  for (const Measures::Measure& measure : measures.measures) {
    to.choice(measure.quantity).flag(measure.low.has_value()).flag(measure.high.has_value());
    to.finite(measure.value).finite(measure.low.value_or(0)).finite(measure.high.value_or(0));
  }
  return to.finish();
}

Bytes encode(const Recording& recording) {
  Writer to(RecordType::recording);
  to.choice(recording.phase).flag(recording.controllable);
  to.number(recording.saved).number(recording.began);
  return to.text(recording.name).text(recording.controller).finish();
}

Bytes encode(const CoverageTile& tile) {
  Writer to(RecordType::coverage_tile);
  return to.number(tile.column).number(tile.row).finite(tile.cell).blob(tile.png).finish();
}

Bytes encode(const Guidance& guidance) {
  Writer to(RecordType::guidance);
  to.finite(guidance.area).finite(guidance.covered);
  to.flag(guidance.lane.has_value()).number(guidance.lane.value_or(0)).finite(guidance.off_lane);
  to.number(static_cast<std::uint8_t>(guidance.plan.size()));
  for (const Eigen::Vector2d& corner : guidance.plan) put(to, corner);
  to.number(static_cast<std::uint8_t>(guidance.gaps.size()));
  for (const Guidance::Gap& gap : guidance.gaps) {
    put(to, gap.centre);
    to.finite(gap.area);
  }
  to.number(static_cast<std::uint16_t>(guidance.lanes.size()));
  for (const Guidance::Lane& lane : guidance.lanes) {
    put(to, lane.from);
    put(to, lane.to);
    to.finite(lane.covered);
  }
  return to.finish();
}

Bytes encode(const Mark& mark) {
  Writer to(RecordType::mark);
  to.number(mark.id).number(mark.time).number(mark.image.value_or(0));
  to.flag(mark.image.has_value());
  put(to, mark.position);
  return to.flag(mark.removed).text(mark.note).finish();
}

Bytes encode(const LastView& view) {
  Writer to(RecordType::last_view);
  return to.number(view.image).number(view.time).blob(view.jpeg).finish();
}

Bytes encode(const WayBack& way) {
  Writer to(RecordType::way_back);
  to.flag(way.lost).flag(way.known);
  return to.finite(way.turn).finite(way.distance).finite(way.sigma).finish();
}

std::uint64_t key(const State&) { return make_key(RecordType::state); }
std::uint64_t key(const AlertRecord& alert) { return make_key(RecordType::alert, alert.id); }
std::uint64_t key(const CameraInfo&) { return make_key(RecordType::camera); }
std::uint64_t key(const ImagePose& pose) { return make_key(RecordType::pose, pose.image); }
std::uint64_t key(const TiePoints& points) {
  return make_key(RecordType::tie_points, points.block);
}
std::uint64_t key(const PlaneGrid& grid) { return make_key(RecordType::plane_grid, grid.image); }
std::uint64_t key(const PlaneColour& colour) {
  return make_key(RecordType::plane_colour, colour.image);
}
std::uint64_t key(const MosaicGrid& mosaic) { return make_key(RecordType::mosaic, mosaic.mosaic); }
namespace {
template <class Tile>
std::uint64_t tile_key(RecordType type, const Tile& tile) {
  return make_key(type,
                  (std::uint64_t{tile.mosaic} << (2 * kPlaceBits)) | place(tile.column, tile.row));
}
}  // namespace
std::uint64_t key(const MosaicTile& tile) { return tile_key(RecordType::mosaic_tile, tile); }
std::uint64_t key(const MosaicOverview& overview) {
  return tile_key(RecordType::mosaic_overview, overview);
}
std::uint64_t key(const LiveImage&) { return make_key(RecordType::live_image); }
std::uint64_t key(const Statistics&) { return make_key(RecordType::statistics); }
std::uint64_t key(const Check&) { return make_key(RecordType::check); }
std::uint64_t key(const Measures&) { return make_key(RecordType::measures); }
std::uint64_t key(const Recording&) { return make_key(RecordType::recording); }
std::uint64_t key(const CoverageTile& tile) {
  return make_key(RecordType::coverage_tile, place(tile.column, tile.row));
}
std::uint64_t key(const Guidance&) { return make_key(RecordType::guidance); }
std::uint64_t key(const Mark& mark) { return make_key(RecordType::mark, mark.id); }
std::uint64_t key(const LastView&) { return make_key(RecordType::last_view); }
std::uint64_t key(const WayBack&) { return make_key(RecordType::way_back); }

}  // namespace nadir::wire
