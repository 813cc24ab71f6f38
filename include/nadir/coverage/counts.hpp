// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How many images show each cell of the ground, kept true when poses are corrected.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "nadir/core/revision.hpp"
#include "nadir/coverage/footprint.hpp"
#include "nadir/coverage/polygon.hpp"

namespace nadir::coverage {

/// Of a tile: cell (column, row) of it is (64 place.column + column, 64 place.row + row) of a
/// raster whose cell (i, j) is the square with its upper left corner at x = side i, y = -side j.
struct Place {
  std::int32_t column = 0, row = 0;
  bool operator==(const Place&) const = default;
  bool operator<(const Place& other) const {
    return std::tie(column, row) < std::tie(other.column, other.row);
  }
};

/// Sparse: 4 kB a tile that has been seen, at most 32 MB, and some 500 bytes an image, at most
/// 64 MB; what would need more is not counted.
class Counts {
 public:
  static constexpr int kTileSide = 64;        ///< cells
  static constexpr std::uint8_t kMost = 127;  ///< images told of a cell
  static constexpr std::size_t kMostTiles = 8192, kMostFootprints = 1 << 17;
  using Cells = std::array<std::uint8_t, std::size_t{kTileSide} * kTileSide>;  ///< row by row

  /// cell: side of a cell; 0: by the first footprint, about a 32nd of its shorter side.
  explicit Counts(double cell = 0) : cell_(cell) {}
  Counts(const Counts&) = delete;
  Counts& operator=(const Counts&) = delete;

  /// Takes the place of an earlier one of the same image.
  void add(const Footprint& footprint);
  /// Moves the footprints that follow these key frames.
  void correct(const std::vector<Correction>& corrections);
  /// To be called before the counts are read: the tiles whose counts have changed since.
  std::vector<Place> recount();

  double cell() const { return cell_; }  ///< 0 before the first footprint
  /// Null where nothing was seen.
  const Cells* at(const Place& place) const;
  /// With something seen.
  std::vector<Place> places() const;
  const Corrections& corrections() const { return corrections_; }

 private:
  struct Kept {
    Footprint footprint;
    Polygon in_cells;  ///< as corrected
  };
  struct Tile {
    Cells cells{};
    std::vector<const Kept*> shown_by;
  };

  Polygon in_cells(const Footprint& footprint) const;
  void put(Kept& kept);
  void take_out(const std::set<const Kept*>& gone);

  double cell_;
  Corrections corrections_;
  std::map<std::uint64_t, Kept> kept_;  ///< by image
  std::map<Place, Tile> tiles_;
  std::set<Place> stale_;
};

}  // namespace nadir::coverage
