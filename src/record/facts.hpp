// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the journal keeps of one shot: enough to make every loose file again.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "archive.hpp"
#include "nadir/core/cloud.hpp"
#include "nadir/core/mark.hpp"
#include "nadir/core/revision.hpp"
#include "nadir/core/tile.hpp"
#include "nadir/record/dive.hpp"

namespace nadir::record {

/// What a window knew when it was adjusted.
struct WindowFacts {
  std::uint32_t submap = 0;
  Scale scale;
  SurveyAxes axes = SurveyAxes::none;
  bool uncertain = false;
  double rms_px = 0;
  std::vector<TiePoint> tie_points;
  std::vector<std::uint64_t> given_up;
};

/// A projected image as it lies on the disk: first as a spare file, at last under its own name.
struct ProjectedFile {
  std::uint64_t image = 0;
  std::uint32_t mosaic = 0;  ///< the mosaic it went to
  std::uint64_t spare = 0;
  WorldFile world;
  std::uint64_t size = 0;
  std::uint32_t crc32 = 0;
};

/// Of one mosaic; in the order of its file's rows.
struct TilePlace {
  std::uint32_t mosaic = 0;
  std::int32_t row = 0, column = 0;
  auto operator<=>(const TilePlace&) const = default;  // NOLINT(modernize-use-nullptr): is none
};

struct Facts {
  bool of_shot = true;  ///< false: what odometry settled after the last shot
  std::uint64_t image = 0;
  Time time = 0;
  std::string name;
  bool rejected = false;
  std::uint32_t dropped_before = 0, missed_before = 0;
  TrackingState state = TrackingState::waiting;
  std::uint32_t submap = 0;
  std::vector<ImagePose> poses;
  std::vector<std::uint64_t> lost;
  std::optional<DeadReckoned> dead_reckoned;
  Health health;
  std::vector<ImageHealth> later_health;
  SurveyAxes axes = SurveyAxes::none;  ///< of the survey; none: as of the window
  std::optional<WindowFacts> window;
  std::optional<Plane> plane;
  std::optional<Grid> grid;
  std::optional<MosaicGrid> mosaic;
  std::optional<ProjectedFile> projected;
  std::vector<TilePlace> tiles;
  std::vector<Alert> alerts;
  std::vector<Correction> corrections;
  std::vector<Join> joins;
  std::vector<std::pair<std::uint32_t, Scale>> scales;  ///< of sub-maps, as corrected
};

TilePlace place_of(const Tile& tile);

/// What is not finite, or farther away than any dive, is left out: no file may hold such a number.
Facts facts_of(const Entry& entry);

Bytes encode(const Facts& facts);
/// None when the bytes are not facts; left out is what facts_of leaves out. Without pixels the grid
/// is black, and read in a third of the time.
std::optional<Facts> decode_facts(std::span<const std::uint8_t> bytes, bool pixels = true);

Bytes encode(const Alert& alert);
std::optional<Alert> decode_alert(std::span<const std::uint8_t> bytes);

Bytes encode(const Mark& mark);
std::optional<Mark> decode_mark(std::span<const std::uint8_t> bytes);

}  // namespace nadir::record
