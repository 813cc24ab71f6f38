// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/counts.hpp"

#include <algorithm>
#include <cmath>

#include "spans.hpp"

namespace nadir::coverage {
namespace {

constexpr double kCellsAcross = 32;    // of the first footprint
constexpr double kLargest = 2048;      // cells a footprint may span: more is a fault of its pose
constexpr double kFarthest = 1 << 24;  // cells from the origin
constexpr int kSide = Counts::kTileSide;

// A side that people can read: 1, 2 or 5 times a power of ten.
double rounded_down(double side) {
  const double power = std::pow(10, std::floor(std::log10(side)));
  constexpr double kSlack = 1 - 1e-9;  // 0.05 is a little less than 5 times 0.01
  for (const double step : {5.0, 2.0}) {
    if (kSlack * step * power <= side) return step * power;
  }
  return power;
}

bool is_sound(const Polygon& in_cells) {
  const auto near = [](const Eigen::Vector2d& corner) {
    return corner.allFinite() && corner.cwiseAbs().maxCoeff() < kFarthest;
  };
  if (in_cells.size() < 3 || !std::ranges::all_of(in_cells, near)) return false;
  const cv::Rect box = bounds(in_cells);
  return box.width <= kLargest && box.height <= kLargest;
}

constexpr int tile_of(int cell) { return cell >= 0 ? cell / kSide : -((kSide - 1 - cell) / kSide); }

cv::Rect cells_of(const Place& place) {
  return {kSide * place.column, kSide * place.row, kSide, kSide};
}

// The tiles with cells of a polygon.
std::vector<Place> places_of(const Polygon& in_cells) {
  std::map<int, std::pair<int, int>> columns;  // by row of tiles: the first and the last
  for_spans(in_cells, bounds(in_cells), [&](int row, int first, int end) {
    const auto [at, is_new] = columns.try_emplace(tile_of(row), tile_of(first), tile_of(end - 1));
    auto& [left, right] = at->second;
    left = std::min(left, tile_of(first));
    right = std::max(right, tile_of(end - 1));
  });
  std::vector<Place> places;
  for (const auto& [row, between] : columns) {
    for (int column = between.first; column <= between.second; ++column)
      places.push_back({column, row});
  }
  return places;
}

void count(const Polygon& in_cells, const Place& place, Counts::Cells& cells) {
  const cv::Rect box = cells_of(place);
  for_spans(in_cells, box, [&](int row, int first, int end) {
    std::uint8_t* line = cells.data() + std::ptrdiff_t{kSide} * (row - box.y);
    for (int i = first - box.x; i < end - box.x; ++i)
      line[i] = static_cast<std::uint8_t>(line[i] + (line[i] < Counts::kMost ? 1 : 0));
  });
}

}  // namespace

Polygon Counts::in_cells(const Footprint& footprint) const {
  const Similarity3 correction = corrections_.at(footprint.submap, footprint.image);
  Polygon polygon;
  for (const Eigen::Vector3d& corner : footprint.corners) {
    const Eigen::Vector3d x_in_survey = correction * corner;
    polygon.emplace_back(x_in_survey.x() / cell_, -x_in_survey.y() / cell_);
  }
  return polygon;
}

void Counts::add(const Footprint& footprint) {
  if (cell_ == 0) {
    const double across = std::min(footprint.width, footprint.length);
    if (!(across > 0) || !std::isfinite(across)) return;
    cell_ = rounded_down(across / kCellsAcross);
  }
  const auto known = kept_.find(footprint.image);
  if (known == kept_.end() && kept_.size() >= kMostFootprints) return;
  if (known != kept_.end()) take_out({&known->second});
  Kept& kept = kept_[footprint.image];
  kept.footprint = footprint;
  put(kept);
}

void Counts::put(Kept& kept) {
  kept.in_cells = in_cells(kept.footprint);
  if (!is_sound(kept.in_cells)) {
    kept.in_cells.clear();
    return;
  }
  for (const Place& place : places_of(kept.in_cells)) {
    if (tiles_.size() >= kMostTiles && !tiles_.contains(place)) continue;
    tiles_[place].shown_by.push_back(&kept);
    stale_.insert(place);
  }
}

void Counts::take_out(const std::set<const Kept*>& gone) {
  std::set<Place> places;
  for (const Kept* kept : gone) {
    if (kept->in_cells.empty()) continue;
    const std::vector<Place> of_one = places_of(kept->in_cells);
    places.insert(of_one.begin(), of_one.end());
  }
  for (const Place& place : places) {
    const auto tile = tiles_.find(place);
    if (tile == tiles_.end()) continue;
    std::erase_if(tile->second.shown_by, [&](const Kept* kept) { return gone.contains(kept); });
    stale_.insert(place);
  }
}

void Counts::correct(const std::vector<Correction>& corrections) {
  std::set<std::pair<std::uint32_t, std::uint64_t>> key_frames;
  for (const Correction& correction : corrections) {
    corrections_.add(correction);
    key_frames.emplace(correction.submap, correction.image);
  }
  std::set<const Kept*> moved;
  for (const auto& [image, kept] : kept_) {
    const std::uint32_t submap = kept.footprint.submap;
    const auto key_frame = corrections_.key_frame_of(submap, image);
    if (key_frame && key_frames.contains({submap, *key_frame})) moved.insert(&kept);
  }
  take_out(moved);
  for (auto& [image, kept] : kept_) {
    if (moved.contains(&kept)) put(kept);
  }
}

std::vector<Place> Counts::recount() {
  std::vector<Place> changed;
  for (const Place& place : stale_) {
    const auto tile = tiles_.find(place);
    Cells cells{};
    for (const Kept* kept : tile->second.shown_by) count(kept->in_cells, place, cells);
    if (cells != tile->second.cells) changed.push_back(place);
    tile->second.cells = cells;
    if (tile->second.shown_by.empty()) tiles_.erase(tile);
  }
  stale_.clear();
  return changed;
}

const Counts::Cells* Counts::at(const Place& place) const {
  const auto tile = tiles_.find(place);
  return tile == tiles_.end() ? nullptr : &tile->second.cells;
}

std::vector<Place> Counts::places() const {
  std::vector<Place> places;
  for (const auto& [place, tile] : tiles_) places.push_back(place);
  return places;
}

}  // namespace nadir::coverage
