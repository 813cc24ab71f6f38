// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The bytes in golden/ are read by the page's own tests too. After a deliberate change of the
// protocol, NADIR_WRITE_GOLDEN=1 build/release/src/wire/test_wire_records writes them anew.
#include "nadir/wire/records.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <random>

#include "nadir/core/check.hpp"

namespace nadir::wire {
namespace {

const Bytes kJpeg = {0xFF, 0xD8, 0xFF, 0xE0, 1, 2, 3, 0xFF, 0xD9};
const Bytes kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n', 1, 2};

constexpr Hello kHello{0xFEDCBA9876543210, 12345678901};

State state_sample() {
  return {.tracking = TrackingState::tracking,
          .axes = SurveyAxes::attitude,
          .finished = true,
          .scale = {.source = ScaleSource::stereo, .sigma = 0.0025},
          .submap = 2,
          .image = 123,
          .time = from_seconds(61.5),
          .captured = 124,
          .oriented = 120,
          .lost = 3,
          .dropped = 1,
          .tie_points = 45678,
          .windows = 116,
          .planes = 110,
          .mosaic_tiles = 77,
          .images_total = 250,
          .rate_hz = 3.75,
          .input = "Portofino \u2013 relitto"};
}

AlertRecord alert_sample() {
  return {.id = 4,
          .alert = {.time = from_seconds(12.25),
                    .image = 25,
                    .kind = AlertKind::tracking_lost,
                    .message = "tracking lost: 9 matches of 30 needed",
                    .remedy = "go back slowly over the last ground"}};
}

CameraInfo camera_sample() {
  return {.width = 968, .height = 728, .fx = 800.5, .fy = 801.25, .cx = 483.5, .cy = 363.5};
}

ImagePose pose_sample() {
  return {.image = 42,
          .time = from_seconds(21),
          .submap = 1,
          .survey_from_camera = {Eigen::Quaterniond(0, 1, 0, 0), {1000000.125, -2.5, 3.0625}},
          .key_frame = true,
          .tie_points = 321,
          .rms_px = 0.5,
          .sigma_position = 0.25};
}

TiePoints tie_points_sample() {
  return {.block = 3,
          .origin = {1e6, 2e6, -3.25},
          .points = {{.index = 0, .offset = {0.5F, -0.25F, 0.125F}, .rgb = {1, 2, 3}},
                     {.index = 511, .offset = {8.0F, 4.0F, 2.0F}, .rgb = {253, 254, 255}}}};
}

PlaneGrid plane_grid_sample() {
  PlaneGrid grid{.image = 42,
                 .submap = 1,
                 .columns = 150,
                 .rows = 100,
                 .camera_in_survey = {1.5, 2.5, 3.5},
                 .max_range = 12.5};
  grid.survey_from_grid << 0.02, 0, -1.5, 0, -0.02, 1, 0, 0.001, -3, 0.0005, 0.00025, 1;
  return grid;
}

MosaicGrid mosaic_sample() {
  MosaicGrid mosaic;
  mosaic.mosaic = 1;
  mosaic.submap = 2;
  mosaic.ground_sampling_distance = 0.005;
  mosaic.world = {.a = 0.005, .d = 0, .b = 0, .e = -0.005, .c = 10.5, .f = -20.25};
  mosaic.plane.normal = {0.6, 0, 0.8};
  mosaic.plane.offset = -3.5;
  return mosaic;
}

MosaicTile tile_sample() {
  return {.mosaic = 1, .column = -2, .row = 3, .jpeg = kJpeg, .mask_png = kPng};
}

Statistics statistics_sample() {
  return {{{.stage = "odometry",
            .rate_in_hz = 4,
            .rate_out_hz = 3.5,
            .processed = 120,
            .depth = 2,
            .dropped = 1,
            .last_ms = 41.5,
            .p95_ms = 62.25},
           {.stage = "plane"}}};
}

Check check_sample() {
  return {{{Verdict::good, "camera", "10.0 images a second"},
           {Verdict::bad, "disk", "/dives cannot be written: read-only", "check the disk"}}};
}

Measures measures_sample() {
  return {{{.quantity = Quantity::altitude, .value = 1.5, .low = 1.0, .high = 3.0},
           {.quantity = Quantity::overlap, .value = 0.75, .low = 0.6},
           {.quantity = Quantity::utc, .value = 1795996800.5}}};
}

Recording recording_sample() {
  return {.phase = Phase::recording,
          .controllable = true,
          .saved = 120,
          .began = from_seconds(3.5),
          .name = "dive-0007",
          .controller = "Anna"};
}

Guidance guidance_sample() {
  return {.plan = {{0, 0}, {10, 0}, {10, 5}, {0, 5}},
          .area = 50,
          .covered = 12.5,
          .gaps = {{{2.5, 1.25}, 0.75}, {{8, 4}, 3}},
          .lanes = {{{0, 1}, {10, 1}, 0.5}, {{10, 3}, {0, 3}, 0}},
          .lane = 1,
          .off_lane = -0.25};
}

Mark mark_sample() {
  return {.id = 3,
          .time = from_seconds(30),
          .image = 61,
          .position = {1.5, -2.5, 0.125},
          .note = "amphora, handle broken"};
}

template <class T>
auto again(std::optional<T> (*decode)(View record)) {
  return [decode](View record) -> std::optional<Bytes> {
    const std::optional<T> value = decode(record);
    return value ? std::optional(encode(*value)) : std::nullopt;
  };
}

struct Sample {
  Bytes bytes;
  std::function<std::optional<Bytes>(View)> decode_and_encode;
};

const std::map<std::string, Sample>& samples() {
  static const std::map<std::string, Sample> all = {
      {"hello", {encode(kHello), again(decode_hello)}},
      {"welcome", {encode(Welcome{0xFEDCBA9876543210, 7}), again(decode_welcome)}},
      {"caught_up", {encode(CaughtUp{12345678901, 2}), again(decode_caught_up)}},
      {"state", {encode(state_sample()), again(decode_state)}},
      {"alert", {encode(alert_sample()), again(decode_alert)}},
      {"camera", {encode(camera_sample()), again(decode_camera)}},
      {"pose", {encode(pose_sample()), again(decode_pose)}},
      {"tie_points", {encode(tie_points_sample()), again(decode_tie_points)}},
      {"plane_grid", {encode(plane_grid_sample()), again(decode_plane_grid)}},
      {"plane_colour", {encode(PlaneColour{42, kJpeg}), again(decode_plane_colour)}},
      {"mosaic", {encode(mosaic_sample()), again(decode_mosaic)}},
      {"mosaic_tile", {encode(tile_sample()), again(decode_mosaic_tile)}},
      {"mosaic_overview",
       {encode(MosaicOverview{1, -1, 0, kJpeg, kPng}), again(decode_mosaic_overview)}},
      {"live_image",
       {encode(LiveImage{9, from_seconds(4.5), kJpeg, {{0, 65535}, {32768, 7}}}),
        again(decode_live_image)}},
      {"statistics", {encode(statistics_sample()), again(decode_statistics)}},
      {"check", {encode(check_sample()), again(decode_check)}},
      {"measures", {encode(measures_sample()), again(decode_measures)}},
      {"recording", {encode(recording_sample()), again(decode_recording)}},
      {"coverage_tile",
       {encode(CoverageTile{.column = -1, .row = 2, .cell = 0.05, .png = kPng}),
        again(decode_coverage_tile)}},
      {"guidance", {encode(guidance_sample()), again(decode_guidance)}},
      {"mark", {encode(mark_sample()), again(decode_mark)}},
      {"last_view", {encode(LastView{8, from_seconds(4), kJpeg}), again(decode_last_view)}},
      {"way_back", {encode(WayBack{true, true, -0.5, 2.25, 0.5}), again(decode_way_back)}}};
  return all;
}

std::string golden_path(const std::string& name) {
  return NADIR_SOURCE_DIR "/tests/wire/golden/" + name + ".bin";
}

Bytes file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Records, EncodeToTheGoldenBytes) {
  for (const auto& [name, sample] : samples()) {
    if (std::getenv("NADIR_WRITE_GOLDEN") != nullptr) {
      std::ofstream(golden_path(name), std::ios::binary)
          .write(reinterpret_cast<const char*>(sample.bytes.data()),
                 static_cast<std::streamsize>(sample.bytes.size()));
    }
    EXPECT_EQ(file(golden_path(name)), sample.bytes) << name;
  }
}

TEST(Records, SurviveDecodingUnchanged) {
  for (const auto& [name, sample] : samples()) {
    EXPECT_EQ(sample.decode_and_encode(sample.bytes), sample.bytes) << name;
  }
}

TEST(Records, DecodeToTheValuesGiven) {
  const State state = decode_state(file(golden_path("state"))).value();
  EXPECT_EQ(state.tracking, TrackingState::tracking);
  EXPECT_EQ(state.mosaic_tiles, 77U);
  EXPECT_EQ(state.input, "Portofino \u2013 relitto");
  const AlertRecord alert = decode_alert(file(golden_path("alert"))).value();
  EXPECT_EQ(alert.alert.image, 25U);
  EXPECT_EQ(alert.alert.kind, AlertKind::tracking_lost);
  const ImagePose pose = decode_pose(file(golden_path("pose"))).value();
  EXPECT_EQ(pose.survey_from_camera.translation.x(), 1000000.125);
  EXPECT_EQ(pose.survey_from_camera.rotation.x(), 1);
  const PlaneGrid grid = decode_plane_grid(file(golden_path("plane_grid"))).value();
  EXPECT_EQ(grid.survey_from_grid(3, 0), 0.0005);
  EXPECT_EQ(decode_mosaic(file(golden_path("mosaic")))->world.f, -20.25);
  const Measures measures = decode_measures(file(golden_path("measures"))).value();
  EXPECT_EQ(measures.measures.at(0).high, 3.0);
  EXPECT_EQ(measures.measures.at(1).high, std::nullopt);
  const Guidance guidance = decode_guidance(file(golden_path("guidance"))).value();
  EXPECT_EQ(guidance.plan.at(2), Eigen::Vector2d(10, 5));
  EXPECT_EQ(guidance.gaps.at(1).area, 3);
  EXPECT_EQ(guidance.lanes.at(1).from.x(), 10);
  EXPECT_EQ(guidance.lane, 1);
  EXPECT_EQ(decode_mark(file(golden_path("mark")))->image, 61U);
}

TEST(Records, AreRefusedWhenCutShortOrProlonged) {
  for (const auto& [name, sample] : samples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      // The first point block is whole without its points; every other cut is a fault.
      const auto result = sample.decode_and_encode(View(sample.bytes).first(size));
      EXPECT_TRUE(!result || name == "tie_points") << name << " cut to " << size;
    }
    Bytes longer = sample.bytes;
    longer.push_back(0);
    EXPECT_FALSE(sample.decode_and_encode(longer)) << name;
  }
}

TEST(Records, AreRefusedWhenOfAnotherVersionOrType) {
  for (const auto& [name, sample] : samples()) {
    for (const std::size_t byte : {0U, 1U}) {
      Bytes other = sample.bytes;
      ++other[byte];
      EXPECT_FALSE(sample.decode_and_encode(other)) << name;
    }
  }
}

TEST(Records, DecodeToFiniteValuesOrNoneWhateverTheBytes) {
  std::mt19937 random(1);
  for (const auto& [name, sample] : samples()) {
    for (int round = 0; round < 3000; ++round) {
      Bytes mutated = sample.bytes;
      const int faults = 1 + static_cast<int>(random() % 4);
      for (int i = 0; i < faults; ++i) {
        mutated[kHeaderSize + random() % (mutated.size() - kHeaderSize)] =
            static_cast<std::uint8_t>(random() % 3 == 0 ? 0xFF : random());
      }
      EXPECT_NO_THROW(sample.decode_and_encode(mutated)) << name;  // encode refuses the infinite
    }
  }
}

TEST(Records, RefuseValuesOutOfRange) {
  CameraInfo no_focal_length = camera_sample();
  no_focal_length.fx = 0;
  EXPECT_FALSE(decode_camera(encode(no_focal_length)));
  ImagePose sheared = pose_sample();
  sheared.survey_from_camera.rotation.coeffs() *= 2;
  EXPECT_FALSE(decode_pose(encode(sheared)));
  TiePoints twice = tie_points_sample();
  twice.points[1].index = 0;
  EXPECT_FALSE(decode_tie_points(encode(twice)));
  MosaicGrid upright = mosaic_sample();
  upright.plane.normal = {1, 0, 0};
  EXPECT_FALSE(decode_mosaic(encode(upright)));
  Guidance beyond = guidance_sample();
  beyond.lane = 2;
  EXPECT_FALSE(decode_guidance(encode(beyond)));
  beyond = guidance_sample();
  beyond.lanes[0].covered = 1.5;
  EXPECT_FALSE(decode_guidance(encode(beyond)));
  EXPECT_FALSE(decode_coverage_tile(encode(CoverageTile{.cell = 0, .png = kPng})));
  EXPECT_FALSE(decode_coverage_tile(encode(CoverageTile{.cell = 1, .png = kJpeg})));
  EXPECT_FALSE(decode_live_image(encode(LiveImage{.image = 1, .time = 0, .jpeg = {1, 2, 3, 4}})));
}

TEST(Records, NeverPutANonFiniteNumberOnTheWire) {
  State state = state_sample();
  state.rate_hz = std::numeric_limits<double>::infinity();
  EXPECT_THROW(encode(state), ContractError);
  TiePoints points = tie_points_sample();
  points.points[0].offset[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(encode(points), ContractError);
}

TEST(Records, ShortenOverlongTextBetweenCharacters) {
  AlertRecord alert = alert_sample();
  alert.alert.message = "x";
  for (int i = 0; i < 2000; ++i) {
    alert.alert.message += "\u00e9";
  }
  const std::string message = decode_alert(encode(alert)).value().alert.message;
  EXPECT_EQ(message.size(), 1023U);
  EXPECT_EQ(message, alert.alert.message.substr(0, 1023));
}

TEST(Records, HaveKeysThatTellThemApart) {
  std::map<std::uint64_t, int> seen;
  ++seen[key(state_sample())];
  ++seen[key(camera_sample())];
  ++seen[key(Statistics{})];
  ++seen[key(Check{})];
  ++seen[key(LiveImage{})];
  ++seen[key(Measures{})];
  ++seen[key(Recording{})];
  ++seen[key(Guidance{})];
  ++seen[key(LastView{})];
  ++seen[key(WayBack{})];
  for (std::uint32_t i = 0; i < 3; ++i) {
    ++seen[key(AlertRecord{.id = i})];
    ImagePose pose;
    pose.image = i;
    ++seen[key(pose)];
    ++seen[key(TiePoints{.block = i})];
    ++seen[key(PlaneGrid{.image = i})];
    ++seen[key(PlaneColour{.image = i})];
    ++seen[key(Mark{.id = i})];
    MosaicGrid mosaic;
    mosaic.mosaic = i;
    ++seen[key(mosaic)];
    for (std::int32_t column = -1; column < 2; ++column) {
      for (std::int32_t row = -1; row < 2; ++row) {
        ++seen[key(MosaicTile{.mosaic = i, .column = column, .row = row})];
        ++seen[key(MosaicOverview{.mosaic = i, .column = column, .row = row})];
        if (i == 0) ++seen[key(CoverageTile{.column = column, .row = row})];
      }
    }
  }
  EXPECT_EQ(seen.size(), 10U + 9 + 3 * (7 + 2 * 9));
  EXPECT_EQ(key(LiveImage{.image = 1}), key(LiveImage{.image = 2}));
}

TEST(Records, CarryAPlaneCloudInTenKilobytes) {
  const Bytes jpeg(9500, 0xFF);
  const Bytes colour = encode(PlaneColour{.image = 1, .jpeg = jpeg});
  EXPECT_LE(encode(plane_grid_sample()).size() + colour.size() - jpeg.size(), 200U);
}

TEST(Records, TakeTheGeometryOfAGrid) {
  Grid grid{.image = 7, .submap = 3, .bgr = cv::Mat(100, 150, CV_8UC3)};
  grid.max_range = 4;
  const PlaneGrid record = plane_grid(grid);
  EXPECT_EQ(record.image, 7U);
  EXPECT_EQ(record.columns, 150);
  EXPECT_EQ(record.rows, 100);
}

}  // namespace
}  // namespace nadir::wire
