// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The journal read through once: all that the loose files say, but the bulk of points and pixels.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <vector>

#include "facts.hpp"
#include "journal.hpp"

namespace nadir::record {

struct ImageFacts {
  bool recorded = false;  ///< its shot is in the journal
  bool rejected = false;
  Time time = 0;
  std::string name;
  TrackingState state = TrackingState::waiting;
  std::uint32_t submap = 0;
  Health health;
  std::optional<ImagePose> live, final;  ///< as first published, and the newest
  std::optional<DeadReckoned> dead_reckoned;
};

/// A projected image and the plane it lies on.
struct ProjectedFacts {
  ProjectedFile file;
  std::uint32_t submap = 0;
  Plane plane;
};

struct MarkFacts {
  Mark mark;
  std::optional<std::uint32_t> submap;  ///< of its image, with which it moves
};

/// Images of each fate; they add up to captured.
struct ImageCounts {
  std::uint64_t captured = 0, oriented = 0, lost = 0;
  std::uint64_t image_rejected = 0, queue_full = 0, camera = 0,
                storage = 0;  ///< dropped, by cause

  std::uint64_t dropped() const { return image_rejected + queue_full + camera + storage; }
};

// NOLINTNEXTLINE(bugprone-exception-escape): moving a map throws nothing here
struct Ledger {
  nlohmann::json about;  ///< what was known when the dive began
  SurveyAxes axes = SurveyAxes::none;
  std::optional<reference::Geodetic> origin;
  std::optional<reference::UtmGrid> grid;  ///< where the survey can be placed on it
  std::map<std::uint64_t, ImageFacts> images;
  std::vector<Alert> alerts;
  std::map<std::uint64_t, MarkFacts> marks;  ///< those that were not removed
  /// Id of a tie point to the sequence of the record with its newest state.
  std::unordered_map<std::uint64_t, std::uint64_t> tie_points;
  std::map<std::uint32_t, Scale> live_scales;  ///< by sub-map, of its newest window
  std::map<std::uint32_t, Scale> scales;       ///< by sub-map, as corrected
  std::set<std::uint32_t> uncertain;           ///< sub-maps placed by dead reckoning
  std::uint64_t windows = 0, planes = 0, grid_points = 0;
  double farthest = 0;  ///< largest coordinate of a point, tie point or grid's
  std::map<std::uint32_t, MosaicGrid> mosaics;
  std::map<std::uint32_t, std::uint64_t> mosaic_seen_first;   ///< the image that began it
  std::map<std::uint32_t, std::uint64_t> mosaic_first_image;  ///< the first that was saved
  std::map<std::uint32_t, std::uint64_t> unsaved;  ///< by mosaic, images in it without a file
  std::set<TilePlace> tiles;
  std::vector<ProjectedFacts> projected;
  Corrections corrections;
  std::map<std::uint32_t, Scale> corrected_scales;  ///< by sub-map
  std::map<std::uint32_t, std::uint32_t> joined;    ///< a sub-map to the one it was joined to
  std::uint64_t queue_full = 0, camera = 0, captured = 0;
  bool ended = false;  ///< the dive came to its end
  std::uint64_t missing_records = 0;

  ImageCounts counts() const;
  /// Of the whole dive: the least certain of its sub-maps'; as corrected, and as published live.
  Scale scale() const;
  Scale live_scale() const;
};

/// With all poses, world files and mosaics' places as corrected (those that are in records, of tie
/// points and grids, are not). Throws InputError as JournalReader does, and when not one record is
/// whole. When told to stop, of what was read by then.
Ledger read_ledger(const path& dive, const std::stop_token& stop = {});

/// First record and last of a journal.
nlohmann::json begin_facts(const DiveInfo& info);
Bytes encode_begin(const nlohmann::json& about);
Bytes encode_end(std::uint64_t captured, std::uint64_t dropped_after);

}  // namespace nadir::record
