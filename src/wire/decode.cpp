// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "nadir/wire/records.hpp"
#include "reader.hpp"

namespace nadir::wire {
namespace {

constexpr double kUnitTolerance = 1e-6;  // of a quaternion's or a normal's length

template <int size>
Eigen::Matrix<double, size, 1> vector(Reader& from) {
  Eigen::Matrix<double, size, 1> vector;
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

bool is_png(const Bytes& bytes) {
  return bytes.size() > 8 && bytes[0] == 0x89 && bytes[1] == 'P' && bytes[2] == 'N' &&
         bytes[3] == 'G';
}

Bytes optional_png(Reader& from) {
  Bytes bytes = from.blob();
  from.require(bytes.empty() || is_png(bytes));
  return bytes;
}

double share(Reader& from) {
  const double value = from.finite();
  from.require(value >= 0 && value <= 1);
  return value;
}

double not_negative(Reader& from) {
  const double value = from.finite();
  from.require(value >= 0);
  return value;
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
  pose.survey_from_camera.translation = vector<3>(from);
  for (double& value : pose.survey_from_camera.rotation.coeffs()) {
    value = from.finite();
  }
  from.require(is_unit(pose.survey_from_camera.rotation.norm()));
  pose.submap = from.number<std::uint32_t>();
  pose.tie_points = from.number<std::uint32_t>();
  pose.rms_px = from.finite<float>();
  pose.sigma_position = from.finite<float>();
  from.require(pose.sigma_position >= 0);
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
  block.origin = vector<3>(from);
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
    row = vector<3>(from).transpose();
  }
  grid.camera_in_survey = vector<3>(from);
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
  mosaic.plane.normal = vector<3>(from);
  // A plane along survey z has no height above X, Y.
  from.require(is_unit(mosaic.plane.normal.norm()) && mosaic.plane.normal.z() != 0);
  mosaic.plane.offset = from.finite();
  return from.finish(mosaic);
}

namespace {
template <class Tile>
std::optional<Tile> decode_tile(View record, RecordType type) {
  Reader from(record, type);
  Tile tile;
  tile.mosaic = from.number<std::uint32_t>();
  tile.column = from.number<std::int32_t>();
  tile.row = from.number<std::int32_t>();
  tile.jpeg = jpeg(from);
  tile.mask_png = optional_png(from);
  return from.finish(std::move(tile));
}
}  // namespace

std::optional<MosaicTile> decode_mosaic_tile(View record) {
  return decode_tile<MosaicTile>(record, RecordType::mosaic_tile);
}

std::optional<MosaicOverview> decode_mosaic_overview(View record) {
  return decode_tile<MosaicOverview>(record, RecordType::mosaic_overview);
}

std::optional<LiveImage> decode_live_image(View record) {
  Reader from(record, RecordType::live_image);
  LiveImage image;
  image.image = from.number<std::uint64_t>();
  image.time = from.number<Time>();
  image.jpeg = jpeg(from);
  const auto tie_points = from.number<std::uint16_t>();
  for (int i = 0; i < tie_points && from.good(); ++i) {
    image.tie_points.push_back(from.number<std::array<std::uint16_t, 2>>());
  }
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

std::optional<Measures> decode_measures(View record) {
  Reader from(record, RecordType::measures);
  Measures measures;
  const auto count = from.number<std::uint8_t>();
  for (int i = 0; i < count && from.good(); ++i) {
    Measures::Measure measure;
    measure.quantity = from.choice(Quantity::utc);
    const bool low = from.flag(), high = from.flag();
    measure.value = from.finite();
    const double least = from.finite(), most = from.finite();
    if (low) measure.low = least;
    if (high) measure.high = most;
    measures.measures.push_back(measure);
  }
  return from.finish(std::move(measures));
}

std::optional<Recording> decode_recording(View record) {
  Reader from(record, RecordType::recording);
  Recording recording;
  recording.phase = from.choice(Phase::ended);
  recording.controllable = from.flag();
  recording.saved = from.number<std::uint64_t>();
  recording.began = from.number<Time>();
  recording.name = from.text();
  recording.controller = from.text();
  return from.finish(std::move(recording));
}

std::optional<CoverageTile> decode_coverage_tile(View record) {
  Reader from(record, RecordType::coverage_tile);
  CoverageTile tile;
  tile.column = from.number<std::int32_t>();
  tile.row = from.number<std::int32_t>();
  tile.cell = from.positive();
  tile.png = from.blob();
  from.require(is_png(tile.png));
  return from.finish(std::move(tile));
}

std::optional<Guidance> decode_guidance(View record) {
  Reader from(record, RecordType::guidance);
  Guidance guidance;
  guidance.area = not_negative(from);
  guidance.covered = not_negative(from);
  const bool on_lane = from.flag();
  const auto lane = from.number<std::uint16_t>();
  if (on_lane) guidance.lane = lane;
  guidance.off_lane = from.finite();
  const auto corners = from.number<std::uint8_t>();
  for (int i = 0; i < corners && from.good(); ++i) guidance.plan.push_back(vector<2>(from));
  const auto gaps = from.number<std::uint8_t>();
  for (int i = 0; i < gaps && from.good(); ++i) {
    const Eigen::Vector2d centre = vector<2>(from);
    guidance.gaps.push_back({centre, not_negative(from)});
  }
  const auto lanes = from.number<std::uint16_t>();
  for (int i = 0; i < lanes && from.good(); ++i) {
    const Eigen::Vector2d begin = vector<2>(from), end = vector<2>(from);
    guidance.lanes.push_back({begin, end, share(from)});
  }
  from.require(!on_lane || lane < lanes);
  return from.finish(std::move(guidance));
}

std::optional<Mark> decode_mark(View record) {
  Reader from(record, RecordType::mark);
  Mark mark;
  mark.id = from.number<std::uint64_t>();
  mark.time = from.number<Time>();
  const auto image = from.number<std::uint64_t>();
  if (from.flag()) mark.image = image;
  mark.position = vector<3>(from);
  mark.removed = from.flag();
  mark.note = from.text();
  return from.finish(std::move(mark));
}

std::optional<LastView> decode_last_view(View record) {
  Reader from(record, RecordType::last_view);
  LastView view;
  view.image = from.number<std::uint64_t>();
  view.time = from.number<Time>();
  view.jpeg = jpeg(from);
  return from.finish(std::move(view));
}

std::optional<WayBack> decode_way_back(View record) {
  Reader from(record, RecordType::way_back);
  WayBack way;
  way.lost = from.flag();
  way.known = from.flag();
  way.turn = from.finite();
  way.distance = not_negative(from);
  way.sigma = not_negative(from);
  return from.finish(way);
}

}  // namespace nadir::wire
