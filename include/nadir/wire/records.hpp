// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The records a server sends to its viewers, paper 3.5; README.md beside this file is their
// written form. Spatial records are in the survey frame, metres (survey units when unscaled).
//
// encode: throws ContractError when a number is not finite; over-long texts are shortened.
// decode: none unless the bytes are exactly one whole record of this type and version with finite
// numbers in their ranges.
// key: under which a server retains the record; a newer record of the same key replaces it, and a
// viewer that joins late is sent every retained record in the order of its sequence.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nadir/core/cloud.hpp"
#include "nadir/core/finding.hpp"
#include "nadir/core/mark.hpp"
#include "nadir/core/stage_stats.hpp"
#include "nadir/core/tile.hpp"
#include "nadir/wire/envelope.hpp"

namespace nadir::wire {

using View = std::span<const std::uint8_t>;

enum class RecordType : std::uint8_t {
  state = 3,
  alert = 4,
  camera = 5,
  pose = 6,
  tie_points = 7,
  plane_grid = 8,
  plane_colour = 9,
  mosaic = 10,
  mosaic_tile = 11,
  live_image = 12,
  statistics = 13,
  check = 15,  // 14 is of the envelope
  measures = 16,
  recording = 17,
  coverage_tile = 18,
  guidance = 19,
  mark = 20,
  last_view = 21,
  way_back = 22,
  mosaic_overview = 23,
};

/// One for the run: the newest says where the dive stands.
struct State {
  TrackingState tracking = TrackingState::waiting;
  SurveyAxes axes = SurveyAxes::none;
  bool finished = false;  ///< the replay has ended; nothing more will come
  Scale scale{};          ///< source none: unscaled
  std::uint32_t submap = 0;
  std::uint64_t image = 0;  ///< newest image processed
  Time time = 0;            ///< of that image
  std::uint64_t captured = 0, oriented = 0, lost = 0, dropped = 0;
  std::uint64_t tie_points = 0, windows = 0, planes = 0, mosaic_tiles = 0;
  std::uint64_t images_total = 0;  ///< 0: unknown
  double rate_hz = 0;              ///< images processed per second of late
  std::string input{};             ///< a name for people
};

struct AlertRecord {
  std::uint64_t id = 0;  ///< counted from 0 in the run
  Alert alert{};
};

/// The pinhole of undistorted images, for drawing: one for the run.
struct CameraInfo {
  std::uint32_t width = 0, height = 0;    ///< px
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
};

/// Every tie point known whose id lies in [block * kTiePointBlock, (block + 1) * kTiePointBlock).
constexpr std::uint64_t kTiePointBlock = 512;
struct TiePoints {
  struct Point {
    std::uint16_t index = 0;  ///< id = block * kTiePointBlock + index; ascending
    std::array<float, 3> offset{};
    std::array<std::uint8_t, 3> rgb{};
  };
  std::uint64_t block = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< x_in_survey = origin + offset
  std::vector<Point> points{};
};

/// A 3DSIP cloud's geometry, as in core's Grid. A correction of poses sends this again, and no
/// pixels.
struct PlaneGrid {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  std::uint16_t columns = 0, rows = 0;
  Eigen::Matrix<double, 4, 3> survey_from_grid = Eigen::Matrix<double, 4, 3>::Zero();
  Eigen::Vector3d camera_in_survey = Eigen::Vector3d::Zero();
  double max_range = 0;
};
PlaneGrid plane_grid(const Grid& grid);

/// Its colours: a JPEG of columns x rows pixels.
struct PlaneColour {
  std::uint64_t image = 0;
  Bytes jpeg{};
};

struct MosaicTile {
  std::uint32_t mosaic = 0;
  std::int32_t column = 0, row = 0;
  Bytes jpeg{};      ///< colours, MosaicGrid::kTileSize squared
  Bytes mask_png{};  ///< 8-bit grey, 0 where nothing was seen; empty: all was seen
};

/// A tile of fewer and larger pixels: mosaic2d::Overviews.
struct MosaicOverview {
  std::uint32_t mosaic = 0;
  std::int32_t column = 0, row = 0;
  Bytes jpeg{};
  Bytes mask_png{};  ///< 8-bit grey, how much was seen
};

/// The current image: only the newest is retained.
struct LiveImage {
  std::uint64_t image = 0;
  Time time = 0;
  Bytes jpeg{};
  /// Where tie points are seen in it: x, y in 65535ths of its width and height; at most 65535.
  std::vector<std::array<std::uint16_t, 2>> tie_points{};
};

struct Statistics {
  std::vector<StageStats> stages{};
};

/// How the equipment does, item by item.
struct Check {
  std::vector<Finding> findings{};  ///< at most 255
};

enum class Quantity : std::uint8_t {
  altitude,        ///< distance to the ground along the optical axis, metres or survey units
  speed,           ///< over ground, metres or survey units a second
  overlap,         ///< share of the last image that the one before it shows
  depth,           ///< metres
  heading,         ///< radians from true north, clockwise
  battery,         ///< share
  free_space,      ///< bytes
  recording_left,  ///< seconds until the disk is full
  blur,            ///< px
  brightness,      ///< share of the range
  temperature,     ///< of the board, degrees Celsius
  utc,             ///< seconds since 1970
};

/// What is known of the vehicle and the board by now.
struct Measures {
  struct Measure {
    Quantity quantity{};
    double value = 0;
    std::optional<double> low{}, high{};  ///< beyond them mapping suffers
  };
  std::vector<Measure> measures{};  ///< at most 255, one a quantity
};

enum class Phase : std::uint8_t {
  waiting,    ///< for a camera, a disk or somebody's word
  recording,  ///< what is seen is kept
  paused,     ///< the disk takes nothing: what is seen now will be missing
  ended,
};

struct Recording {
  Phase phase{};
  bool controllable = false;  ///< dives can be begun and ended from a page
  std::uint64_t saved = 0;    ///< images that are durable
  Time began = 0;             ///< of the survey's clock
  std::string name{};         ///< of the dive's folder
  std::string controller{};   ///< who controls, as they call themselves; empty: nobody
};

/// How often ground was seen, north up: pixel (column, row) of tile (i, j) is the square cell at
/// x = cell (kCells i + column), y = -cell (kCells j + row), those of its upper left corner.
/// A pixel: images that show the cell, at most 127; 128 more where it is to be covered.
struct CoverageTile {
  static constexpr int kCells = 64;
  std::int32_t column = 0, row = 0;
  double cell = 0;  ///< side, survey units; the same for all tiles of a run
  Bytes png{};      ///< 8-bit grey
};

/// Where to swim.
struct Guidance {
  struct Gap {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double area = 0;
  };
  struct Lane {
    Eigen::Vector2d from = Eigen::Vector2d::Zero(), to = Eigen::Vector2d::Zero();
    double covered = 0;  ///< share
  };
  std::vector<Eigen::Vector2d> plan{};  ///< corners in turn; none: the ground swept is the area
  double area = 0, covered = 0;  ///< to be covered, and of that covered; survey units squared
  std::vector<Gap> gaps{};       ///< the nearest first, at most 255
  std::vector<Lane> lanes{};     ///< in the order of the plan, at most 65535
  std::optional<std::uint16_t> lane{};  ///< the one being swum
  double off_lane = 0;                  ///< how far to the right of it, seen along its direction
};

/// The last image that could be oriented, to be found again.
struct LastView {
  std::uint64_t image = 0;
  Time time = 0;
  Bytes jpeg{};
};

/// From where the vehicle is to where the last view was taken, by dead reckoning.
struct WayBack {
  bool lost = false;    ///< tracking is; else the rest is void
  bool known = false;   ///< by how much and where to
  double turn = 0;      ///< radians, clockwise from the top of the image
  double distance = 0;  ///< survey units
  double sigma = 0;     ///< of the distance
};

Bytes encode(const State& state);
Bytes encode(const AlertRecord& alert);
Bytes encode(const CameraInfo& camera);
Bytes encode(const ImagePose& pose);
Bytes encode(const TiePoints& points);
Bytes encode(const PlaneGrid& grid);
Bytes encode(const PlaneColour& colour);
Bytes encode(const MosaicGrid& mosaic);  ///< world in survey X, Y; of the plane: normal and offset
Bytes encode(const MosaicTile& tile);
Bytes encode(const MosaicOverview& overview);
Bytes encode(const LiveImage& image);
Bytes encode(const Statistics& statistics);
Bytes encode(const Check& check);
Bytes encode(const Measures& measures);
Bytes encode(const Recording& recording);
Bytes encode(const CoverageTile& tile);
Bytes encode(const Guidance& guidance);
Bytes encode(const Mark& mark);
Bytes encode(const LastView& view);
Bytes encode(const WayBack& way);

std::optional<State> decode_state(View record);
std::optional<AlertRecord> decode_alert(View record);
std::optional<CameraInfo> decode_camera(View record);
std::optional<ImagePose> decode_pose(View record);
std::optional<TiePoints> decode_tie_points(View record);
std::optional<PlaneGrid> decode_plane_grid(View record);
std::optional<PlaneColour> decode_plane_colour(View record);
std::optional<MosaicGrid> decode_mosaic(View record);
std::optional<MosaicTile> decode_mosaic_tile(View record);
std::optional<MosaicOverview> decode_mosaic_overview(View record);
std::optional<LiveImage> decode_live_image(View record);
std::optional<Statistics> decode_statistics(View record);
std::optional<Check> decode_check(View record);
std::optional<Measures> decode_measures(View record);
std::optional<Recording> decode_recording(View record);
std::optional<CoverageTile> decode_coverage_tile(View record);
std::optional<Guidance> decode_guidance(View record);
std::optional<Mark> decode_mark(View record);
std::optional<LastView> decode_last_view(View record);
std::optional<WayBack> decode_way_back(View record);

std::uint64_t key(const State& state);
std::uint64_t key(const AlertRecord& alert);
std::uint64_t key(const CameraInfo& camera);
std::uint64_t key(const ImagePose& pose);
std::uint64_t key(const TiePoints& points);
std::uint64_t key(const PlaneGrid& grid);
std::uint64_t key(const PlaneColour& colour);
std::uint64_t key(const MosaicGrid& mosaic);
std::uint64_t key(const MosaicTile& tile);
std::uint64_t key(const MosaicOverview& overview);
std::uint64_t key(const LiveImage& image);
std::uint64_t key(const Statistics& statistics);
std::uint64_t key(const Check& check);
std::uint64_t key(const Measures& measures);
std::uint64_t key(const Recording& recording);
std::uint64_t key(const CoverageTile& tile);
std::uint64_t key(const Guidance& guidance);
std::uint64_t key(const Mark& mark);
std::uint64_t key(const LastView& view);
std::uint64_t key(const WayBack& way);

}  // namespace nadir::wire
