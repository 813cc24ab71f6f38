// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/recorded.hpp"

#include <opencv2/core.hpp>
#include <utility>

#include "earlier_summary.hpp"
#include "ledger.hpp"
#include "loose_file.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

constexpr int kSide = MosaicGrid::kTileSize;

std::shared_ptr<const Shot> shot_of(const Facts& facts) {
  auto shot = std::make_shared<Shot>();
  shot->image = facts.image;
  shot->time = facts.time;
  shot->name = facts.name;
  shot->dropped_before = facts.dropped_before;
  shot->missed_before = facts.missed_before;
  if (!facts.rejected) {
    auto frame = std::make_shared<Frame>();
    frame->image = facts.image;
    frame->time = facts.time;
    frame->name = facts.name;
    shot->frame = frame;
  }
  return shot;
}

std::shared_ptr<const Window> window_of(const WindowFacts& facts) {
  auto window = std::make_shared<Window>();
  window->submap = facts.submap;
  window->tie_points = facts.tie_points;
  window->given_up = facts.given_up;
  window->scale = facts.scale;
  window->axes = facts.axes;
  window->uncertain = facts.uncertain;
  window->rms_px = facts.rms_px;
  return window;
}

Entry entry_of(Facts facts, std::vector<Alert> alerts) {
  auto orientation = std::make_shared<Orientation>();
  if (facts.of_shot) orientation->shot = shot_of(facts);
  orientation->state = facts.state;
  orientation->submap = facts.submap;
  orientation->poses = std::move(facts.poses);
  orientation->lost = std::move(facts.lost);
  orientation->dead_reckoned = facts.dead_reckoned;
  if (facts.window) orientation->window = window_of(*facts.window);
  orientation->axes = facts.axes;
  orientation->health = facts.health;
  orientation->alerts = std::move(alerts);
  Entry entry{orientation, {}, {}, {}};
  if (facts.grid) {
    auto cloud = std::make_shared<Cloud>();
    cloud->grid = std::move(facts.grid);
    entry.cloud = cloud;
  }
  if (!facts.corrections.empty() || !facts.scales.empty()) {
    auto revision = std::make_shared<Revision>();
    revision->corrections = std::move(facts.corrections);
    revision->joins = std::move(facts.joins);
    revision->scales = std::move(facts.scales);
    entry.revisions.push_back(revision);
  }
  return entry;
}

void give_entries(const path& dive, const Recorded& to, const std::stop_token& stop) {
  JournalReader journal(dive);
  std::vector<Alert> alerts;
  while (const auto record = stop.stop_requested() ? std::nullopt : journal.next()) {
    if (record->type == RecordType::alert) {
      if (const auto alert = decode_alert(record->payload)) alerts.push_back(*alert);
    } else if (record->type == RecordType::mark && to.mark) {
      if (const auto mark = decode_mark(record->payload)) to.mark(*mark);
    } else if (record->type == RecordType::shot) {
      auto facts = decode_facts(record->payload);
      if (!facts) continue;
      alerts.insert(alerts.end(), facts->alerts.begin(), facts->alerts.end());
      to.entry(entry_of(std::move(*facts), std::exchange(alerts, {})));
    }
  }
}

/// Of the raster's pixel (0, 0), on the survey's axes; none when the file is missing or wrong.
std::optional<WorldFile> read_world(const path& name,
                                    const std::optional<reference::UtmGrid>& utm) {
  std::ifstream in = open_to_read(name);
  WorldFile world;
  if (!(in >> world.a >> world.d >> world.b >> world.e >> world.c >> world.f)) return std::nullopt;
  if (utm) {
    const Eigen::Vector2d origin = (*utm)(Eigen::Vector2d::Zero());
    world.c -= origin.x();
    world.f -= origin.y();
    for (double* value : {&world.a, &world.d, &world.b, &world.e, &world.c, &world.f}) {
      *value /= utm->scale();
    }
  }
  return world;
}

// False when it is left out, from a damaged row on.
bool give_mosaic(const path& dive, const Ledger& ledger, MosaicGrid grid, const Recorded& to,
                 const std::stop_token& stop) {
  const path name = dive / "mosaic2d" / ("mosaic-" + padded(grid.mosaic, 3));
  const auto world = read_world(path(name).concat(".pgw"), ledger.grid);
  std::ifstream file = open_to_read(path(name).concat(".png"));
  image_io::PngReader png(file);
  if (!world || png.width() == 0) return false;
  // Its first pixel is that of a tile.
  grid.world = *world;
  cv::Mat strip(kSide, png.width(), CV_8UC4);
  for (int row = 0; row < png.height() / kSide && !stop.stop_requested(); ++row) {
    if (!png.rows(strip)) return false;
    std::vector<std::shared_ptr<const Tile>> tiles;
    for (int column = 0; column < png.width() / kSide; ++column) {
      const cv::Mat bgra = strip.colRange(column * kSide, (column + 1) * kSide).clone();
      cv::Mat alpha;
      cv::extractChannel(bgra, alpha, 3);
      if (cv::countNonZero(alpha) == 0) continue;
      tiles.push_back(std::make_shared<Tile>(Tile{grid.mosaic, column, row, bgra}));
    }
    to.mosaic(grid, tiles);
  }
  return true;
}

}  // namespace

GivenAgain give_again(const path& dive, const Recorded& to, const std::stop_token& stop) {
  const Ledger ledger = read_ledger(dive, stop);
  give_entries(dive, to, stop);
  GivenAgain given;
  given.captured = ledger.counts().captured;
  given.missing_records = ledger.missing_records;
  const EarlierSummary earlier = read_summary(dive);
  if (earlier.outlives(ledger)) given.captured_once = earlier.captured;
  for (const auto& [number, grid] : ledger.mosaics) {
    if (!give_mosaic(dive, ledger, grid, to, stop)) ++given.mosaics_left_out;
  }
  return given;
}

}  // namespace nadir::record
