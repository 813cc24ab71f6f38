// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "nadir/wire/records.hpp"
#include "reader.hpp"

namespace nadir::wire {
namespace {

constexpr double kUnitTolerance = 1e-6;  // of a quaternion's or a normal's length

Eigen::Vector3d vector3(Reader& from) {
  Eigen::Vector3d vector;
  for (double& value : vector) {
    value = from.finite();
  }
  return vector;
}

bool is_unit(double length) { return std::abs(length - 1) <= kUnitTolerance; }

std::optional<AlertKind> alert_kind(std::string_view name) {
  for (int i = 0; to_string(static_cast<AlertKind>(i)) != "unknown"; ++i) {
    if (to_string(static_cast<AlertKind>(i)) == name) {
      return static_cast<AlertKind>(i);
    }
  }
  return std::nullopt;
}

Bytes jpeg(Reader& from) {
  Bytes bytes = from.blob();
  from.require(bytes.size() > 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF);
  return bytes;
}

Bytes optional_png(Reader& from) {
  Bytes bytes = from.blob();
  from.require(bytes.empty() || (bytes.size() > 8 && bytes[0] == 0x89 && bytes[1] == 'P' &&
                                 bytes[2] == 'N' && bytes[3] == 'G'));
  return bytes;
}

StageStats stage_stats(Reader& from) {
  StageStats stage;
  stage.stage = from.text();
  stage.rate_in_hz = from.finite();
  stage.rate_out_hz = from.finite();
  stage.processed = from.number<std::uint64_t>();
  stage.dropped = from.number<std::uint64_t>();
  stage.depth = from.number<std::uint32_t>();
  stage.last_ms = from.finite();
  stage.p95_ms = from.finite();
  return stage;
}

}  // namespace

std::optional<State> decode_state(View record) {
  Reader from(record, RecordType::state);
  State state;
  state.tracking = from.choice(TrackingState::lost);
  state.axes = from.choice(SurveyAxes::doubtful);
  state.finished = from.flag();
  state.scale.source = from.choice(ScaleSource::poses);
  state.submap = from.number<std::uint32_t>();
  state.image = from.number<std::uint64_t>();
  state.time = from.number<Time>();
  state.scale.sigma = from.finite();
  state.rate_hz = from.finite();
  from.require(state.scale.sigma >= 0 && state.rate_hz >= 0);
  for (std::uint64_t* count :
       {&state.captured, &state.oriented, &state.lost, &state.dropped, &state.tie_points,
        &state.windows, &state.planes, &state.mosaic_tiles, &state.images_total}) {
    *count = from.number<std::uint64_t>();
  }
  state.input = from.text();
  return from.finish(std::move(state));
}

std::optional<AlertRecord> decode_alert(View record) {
  Reader from(record, RecordType::alert);
  AlertRecord alert;
  alert.id = from.number<std::uint64_t>();
  alert.alert.time = from.number<Time>();
  const auto image = from.number<std::uint64_t>();
  if (from.flag()) {
    alert.alert.image = image;
  }
  const std::optional<AlertKind> kind = alert_kind(from.text());
  from.require(kind.has_value());
  alert.alert.kind = kind.value_or(AlertKind{});
  alert.alert.message = from.text();
  alert.alert.remedy = from.text();
  return from.finish(std::move(alert));
}

std::optional<CameraInfo> decode_camera(View record) {
  Reader from(record, RecordType::camera);
  CameraInfo camera;
  camera.width = from.number<std::uint32_t>();
  camera.height = from.number<std::uint32_t>();
  from.require(camera.width > 0 && camera.height > 0);
  camera.fx = from.positive();
  camera.fy = from.positive();
  camera.cx = from.finite();
  camera.cy = from.finite();
  return from.finish(camera);
}

std::optional<ImagePose> decode_pose(View record) {
  Reader from(record, RecordType::pose);
  ImagePose pose;
  pose.image = from.number<std::uint64_t>();
  pose.time = from.number<Time>();
  pose.survey_from_camera.translation = vector3(from);
  for (double& value : pose.survey_from_camera.rotation.coeffs()) {
    value = from.finite();
  }
  from.require(is_unit(pose.survey_from_camera.rotation.norm()));
  pose.submap = from.number<std::uint32_t>();
  pose.tie_points = from.number<std::uint32_t>();
  pose.rms_px = from.finite<float>();
  pose.key_frame = from.flag();
  return from.finish(pose);
}

std::optional<TiePoints> decode_tie_points(View record) {
  constexpr std::size_t kBodyFront = 32, kPointSize = 17;
  Reader from(record, RecordType::tie_points);
  const std::size_t body = record.size() - std::min(record.size(), kHeaderSize + kBodyFront);
  from.require(body % kPointSize == 0 && body / kPointSize <= kTiePointBlock);
  if (!from.good()) {
    return std::nullopt;
  }
  TiePoints block;
  block.block = from.number<std::uint64_t>();
  block.origin = vector3(from);
  block.points.resize(body / kPointSize);
  for (TiePoints::Point& point : block.points) {
    for (float& value : point.offset) {
      value = static_cast<float>(from.finite<float>());
    }
  }
  std::uint64_t least = 0;
  for (TiePoints::Point& point : block.points) {
    point.index = from.number<std::uint16_t>();
    from.require(point.index >= least && point.index < kTiePointBlock);
    least = point.index + 1U;
  }
  for (TiePoints::Point& point : block.points) {
    point.rgb = from.number<std::array<std::uint8_t, 3>>();
  }
  return from.finish(std::move(block));
}

std::optional<PlaneGrid> decode_plane_grid(View record) {
  Reader from(record, RecordType::plane_grid);
  PlaneGrid grid;
  grid.image = from.number<std::uint64_t>();
  grid.submap = from.number<std::uint32_t>();
  grid.columns = from.number<std::uint16_t>();
  grid.rows = from.number<std::uint16_t>();
  from.require(grid.columns > 1 && grid.rows > 1);
  for (auto row : grid.survey_from_grid.rowwise()) {
    row = vector3(from).transpose();
  }
  grid.camera_in_survey = vector3(from);
  grid.max_range = from.positive();
  return from.finish(grid);
}

std::optional<PlaneColour> decode_plane_colour(View record) {
  Reader from(record, RecordType::plane_colour);
  PlaneColour colour;
  colour.image = from.number<std::uint64_t>();
  colour.jpeg = jpeg(from);
  return from.finish(std::move(colour));
}

std::optional<MosaicGrid> decode_mosaic(View record) {
  Reader from(record, RecordType::mosaic);
  MosaicGrid mosaic;
  mosaic.mosaic = from.number<std::uint32_t>();
  mosaic.submap = from.number<std::uint32_t>();
  mosaic.ground_sampling_distance = from.positive();
  WorldFile& world = mosaic.world;
  for (double* value : {&world.a, &world.d, &world.b, &world.e, &world.c, &world.f}) {
    *value = from.finite();
  }
  mosaic.plane.normal = vector3(from);
  // A plane along survey z has no height above X, Y.
  from.require(is_unit(mosaic.plane.normal.norm()) && mosaic.plane.normal.z() != 0);
  mosaic.plane.offset = from.finite();
  return from.finish(mosaic);
}

std::optional<MosaicTile> decode_mosaic_tile(View record) {
  Reader from(record, RecordType::mosaic_tile);
  MosaicTile tile;
  tile.mosaic = from.number<std::uint32_t>();
  tile.column = from.number<std::int32_t>();
  tile.row = from.number<std::int32_t>();
  tile.jpeg = jpeg(from);
  tile.mask_png = optional_png(from);
  return from.finish(std::move(tile));
}

std::optional<LiveImage> decode_live_image(View record) {
  Reader from(record, RecordType::live_image);
  LiveImage image;
  image.image = from.number<std::uint64_t>();
  image.time = from.number<Time>();
  image.jpeg = jpeg(from);
  return from.finish(std::move(image));
}

std::optional<Statistics> decode_statistics(View record) {
  Reader from(record, RecordType::statistics);
  Statistics statistics;
  const auto count = from.number<std::uint8_t>();
  for (int i = 0; i < count && from.good(); ++i) {
    statistics.stages.push_back(stage_stats(from));
  }
  return from.finish(std::move(statistics));
}

std::optional<Check> decode_check(View record) {
  Reader from(record, RecordType::check);
  Check check;
  const auto count = from.number<std::uint8_t>();
  for (int i = 0; i < count && from.good(); ++i) {
    Finding finding;
    finding.verdict = from.choice(Verdict::absent);
    finding.item = from.text();
    finding.found = from.text();
    finding.remedy = from.text();
    check.findings.push_back(std::move(finding));
  }
  return from.finish(std::move(check));
}

}  // namespace nadir::wire
