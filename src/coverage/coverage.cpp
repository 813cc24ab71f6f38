// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/coverage/coverage.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "gaps.hpp"
#include "spans.hpp"
#include "swept.hpp"

namespace nadir::coverage {
namespace {

constexpr int kSide = Counts::kTileSide;
constexpr std::uint8_t kWanted = 128;
constexpr double kClosing = 0.75;              // footprint widths on either side
constexpr std::int64_t kMostBlocks = 1 << 18;  // without what is added for growth
constexpr int kSlack = 2;  // tiles or a quarter more on each side, so that few make the frame anew

cv::Rect cells_of(const Place& place) {
  return {kSide * place.column, kSide * place.row, kSide, kSide};
}

cv::Rect grown(const cv::Rect& rect, int x, int y) {
  return {rect.x - x, rect.y - y, rect.width + 2 * x, rect.height + 2 * y};
}

bool contains(const cv::Rect& outer, const cv::Rect& inner) { return (outer & inner) == inner; }

constexpr int floor_div(int value, int by) {
  return value >= 0 ? value / by : -((by - 1 - value) / by);
}

// Of a cell in its tile.
std::size_t index_of(const cv::Point& in_tile) {
  return static_cast<std::size_t>(in_tile.y) * kSide + static_cast<std::size_t>(in_tile.x);
}

// Tiles, not cells.
cv::Rect tiles_around(const cv::Rect& cells) {
  const cv::Point first(floor_div(cells.x, kSide), floor_div(cells.y, kSide));
  const cv::Point last(floor_div(cells.x + cells.width - 1, kSide),
                       floor_div(cells.y + cells.height - 1, kSide));
  return {first, last + cv::Point(1, 1)};
}

Place place_of(const cv::Point& cell) {
  return {floor_div(cell.x, kSide), floor_div(cell.y, kSide)};
}

int margin_of(double radius_in_cells, int side) {
  return radius_in_cells > 0 ? Swept::margin(radius_in_cells / side) : 1;
}

// The smallest blocks that are not too many.
int block_side(const cv::Rect& tiles, double radius_in_cells) {
  int side = 1;
  for (; side < kSide; side *= 2) {
    const std::int64_t margin = 2 * std::int64_t{margin_of(radius_in_cells, side)};
    const std::int64_t across = kSide / side;
    if ((across * tiles.width + margin) * (across * tiles.height + margin) <= kMostBlocks) break;
  }
  return side;
}

// To what a raster of half a million blocks holds with its margin, around the vehicle.
bool cut_to_reach(cv::Rect& tiles, const std::optional<Place>& vehicle) {
  constexpr int kReach = 340;
  const auto fits = [&](int side) { return side <= 4 * kReach; };
  if (fits(tiles.width) && fits(tiles.height) && tiles.area() <= 4 * kReach * kReach) return false;
  const cv::Point last = tiles.br() - cv::Point(1, 1);
  const Place from = vehicle.value_or(Place{});
  const cv::Point nearest(std::clamp(from.column, tiles.x, last.x),
                          std::clamp(from.row, tiles.y, last.y));
  tiles &= cv::Rect(nearest.x - kReach, nearest.y - kReach, 2 * kReach, 2 * kReach);
  return true;
}

double sum_of(const cv::Mat1w& cells) { return cells.empty() ? 0 : cv::sum(cells)[0]; }

}  // namespace

/// What is to be covered and what of it was seen, by blocks of side x side cells.
struct Coverage::Blocks {
  int side = 1;
  double radius = 0;       ///< of the closing, cells
  bool cut = false;        ///< not all that was seen or is to be covered is in it
  cv::Rect tiles;          ///< that it holds
  cv::Rect frame;          ///< in blocks of the whole raster: those of the tiles and a margin
  cv::Mat1w wanted, seen;  ///< cells in each block; seen ones only where they are wanted
  cv::Mat1b any, whole;    ///< 255 where seen is more than 0, where it is all
  Swept swept;
  cv::Rect changed;  ///< of any and whole

  void begin(const cv::Rect& held, double radius_in_cells);
  cv::Rect of(const Place& place) const {
    const int across = kSide / side;
    return cv::Rect(across * place.column, across * place.row, across, across) - frame.tl();
  }
  cv::Point of_cell(const cv::Point& cell) const {
    return cv::Point(floor_div(cell.x, side), floor_div(cell.y, side)) - frame.tl();
  }
  bool holds(const Place& place) const { return tiles.contains({place.column, place.row}); }
  void add_places(const cv::Mat& marked, std::set<Place>& places) const;
};

void Coverage::Blocks::begin(const cv::Rect& held, double radius_in_cells) {
  const int across = kSide / side, margin = margin_of(radius_in_cells, side);
  tiles = held;
  radius = radius_in_cells;
  frame = grown({across * tiles.x, across * tiles.y, across * tiles.width, across * tiles.height},
                margin, margin);
  wanted = cv::Mat1w::zeros(frame.size());
  seen = cv::Mat1w::zeros(frame.size());
  any = cv::Mat1b::zeros(frame.size());
  whole = cv::Mat1b::zeros(frame.size());
  swept.begin(frame.size(), radius_in_cells / side);
  changed = cv::Rect({}, frame.size());
}

void Coverage::Blocks::add_places(const cv::Mat& marked, std::set<Place>& places) const {
  const cv::Rect all({}, frame.size());
  const cv::Rect touched =
      tiles_around({frame.x * side, frame.y * side, frame.width * side, frame.height * side});
  for (int row = touched.y; row < touched.y + touched.height; ++row) {
    for (int column = touched.x; column < touched.x + touched.width; ++column) {
      const Place place{column, row};
      if (cv::countNonZero(marked(of(place) & all)) > 0) places.insert(place);
    }
  }
}

Coverage::Coverage(double cell) : counts_(cell) {}
Coverage::~Coverage() = default;

Polygon Coverage::in_cells(const Polygon& polygon) const {
  Polygon scaled;
  for (const Eigen::Vector2d& corner : polygon)
    scaled.emplace_back(corner.x() / cell(), -corner.y() / cell());
  return scaled;
}

void Coverage::add(const Footprint& footprint) {
  counts_.add(footprint);
  if (cell() == 0) return;
  if (!first_) first_ = {footprint.image, footprint.submap, {}, footprint.width, footprint.length};
  const Eigen::Vector3d x_in_survey =
      corrections().at(footprint.submap, footprint.image) * footprint.corners.front();
  const Eigen::Vector2d at = in_cells({x_in_survey.head<2>()}).front();
  constexpr double kFarthest = 1 << 24;
  if (at.cwiseAbs().maxCoeff() < kFarthest)
    newest_ = place_of({static_cast<int>(at.x()), static_cast<int>(at.y())});
}

void Coverage::correct(const std::vector<Correction>& corrections) { counts_.correct(corrections); }

void Coverage::aim(std::optional<Polygon> ground) {
  if (ground == aim_) return;
  aim_ = std::move(ground);
  aimed_anew_ = true;
}

double Coverage::footprint_width() const {
  return first_ ? first_->width * corrections().at(first_->submap, first_->image).scale : 0;
}

double Coverage::radius_in_cells() const {
  return aim_ ? 0 : kClosing * footprint_width() / cell();
}

// Tiles.
cv::Rect Coverage::extent() const {
  constexpr int kFarthest = 1 << 18;
  if (aim_) {
    return tiles_around(bounds(in_cells(*aim_))) &
           cv::Rect(-kFarthest, -kFarthest, 2 * kFarthest, 2 * kFarthest);
  }
  cv::Rect tiles;
  for (const Place& place : counts_.places()) tiles |= cv::Rect(place.column, place.row, 1, 1);
  return tiles;
}

bool Coverage::must_be_framed_anew() const {
  if (!blocks_ || aimed_anew_) return true;
  if (aim_) return false;
  constexpr double kOther = 0.1;  // of the radius: the map was scaled meanwhile
  if (std::abs(radius_in_cells() - blocks_->radius) > kOther * blocks_->radius) return true;
  if (blocks_->cut) return newest_ && !blocks_->holds(*newest_);
  const cv::Rect tiles = extent();
  return !contains(blocks_->tiles, tiles) || block_side(tiles, radius_in_cells()) != blocks_->side;
}

void Coverage::frame_anew(std::set<Place>& changed) {
  if (blocks_) blocks_->add_places(blocks_->wanted, changed);
  blocks_ = std::make_unique<Blocks>();
  aimed_anew_ = false;
  cv::Rect tiles = extent();
  blocks_->cut = cut_to_reach(tiles, newest_);
  blocks_->side = block_side(tiles, radius_in_cells());
  if (!aim_ && !blocks_->cut)
    tiles = grown(tiles, std::max(kSlack, tiles.width / 4), std::max(kSlack, tiles.height / 4));
  blocks_->begin(tiles, radius_in_cells());
  if (aim_) {
    const cv::Rect& held = blocks_->tiles;
    const cv::Rect cells(kSide * held.x, kSide * held.y, kSide * held.width, kSide * held.height);
    for_spans(in_cells(*aim_), cells, [&](int row, int first, int end) {
      for (int from = first; from < end;) {
        const int to = std::min(end, (floor_div(from, blocks_->side) + 1) * blocks_->side);
        std::uint16_t& wanted = blocks_->wanted(blocks_->of_cell({from, row}));
        wanted = static_cast<std::uint16_t>(wanted + to - from);
        from = to;
      }
    });
    blocks_->add_places(blocks_->wanted, changed);
  }
  for (const Place& place : counts_.places()) take_in(place);
}

void Coverage::take_in(const Place& place) {
  Blocks& blocks = *blocks_;
  if (!blocks.holds(place)) return;
  const cv::Rect box = cells_of(place), to = blocks.of(place);
  cv::Mat1w seen(to.size(), 0);
  const auto take = [&](const Counts::Cells& cells, int row, int first, int end) {
    const std::uint8_t* line = cells.data() + std::ptrdiff_t{kSide} * (row - box.y);
    std::uint16_t* into = seen[(row - box.y) / blocks.side];
    for (int i = first - box.x; i < end - box.x; ++i)
      into[i / blocks.side] = static_cast<std::uint16_t>(into[i / blocks.side] + (line[i] ? 1 : 0));
  };
  if (const Counts::Cells* cells = counts_.at(place)) {
    if (aim_) {
      for_spans(in_cells(*aim_), box,
                [&](int row, int first, int end) { take(*cells, row, first, end); });
    } else {
      for (int row = box.y; row < box.y + kSide; ++row) take(*cells, row, box.x, box.x + kSide);
    }
  }
  const cv::Mat1b any(seen > 0), whole(seen >= blocks.side * blocks.side);
  const cv::Mat1b differs((any ^ blocks.any(to)) | (whole ^ blocks.whole(to)));
  if (cv::countNonZero(differs) > 0) blocks.changed |= to;
  seen.copyTo(blocks.seen(to));
  any.copyTo(blocks.any(to));
  whole.copyTo(blocks.whole(to));
}

void Coverage::work_out(std::set<Place>& changed) {
  Blocks& blocks = *blocks_;
  if (!aim_) {
    const cv::Mat1b before = blocks.swept.all().clone();
    blocks.swept.update(blocks.any, blocks.whole, blocks.changed);
    blocks.add_places(before ^ blocks.swept.all(), changed);
    cv::Mat1w whole;
    constexpr double kMark = 255;
    blocks.swept.all().convertTo(whole, CV_16U, blocks.side * blocks.side / kMark);
    blocks.wanted = cv::max(whole, blocks.seen);
  }
  blocks.changed = {};
  find_gaps();
}

std::vector<Place> Coverage::update() {
  const std::vector<Place> counted = counts_.recount();
  if (cell() == 0) return {};
  std::set<Place> changed(counted.begin(), counted.end());
  if (must_be_framed_anew()) {
    frame_anew(changed);
    work_out(changed);
  } else if (!counted.empty()) {
    for (const Place& place : counted) take_in(place);
    work_out(changed);
  }
  return {changed.begin(), changed.end()};
}

Coverage::Pixels Coverage::pixels(const Place& place) const {
  Pixels pixels{};
  const Counts::Cells* cells = counts_.at(place);
  if (cells) pixels = *cells;
  if (!blocks_) return pixels;
  const cv::Rect box = cells_of(place);
  if (aim_) {
    for_spans(in_cells(*aim_), box, [&](int row, int first, int end) {
      std::uint8_t* line = pixels.data() + std::ptrdiff_t{kSide} * (row - box.y);
      for (int i = first - box.x; i < end - box.x; ++i) line[i] |= kWanted;
    });
    return pixels;
  }
  const cv::Rect all({}, blocks_->frame.size());
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      std::uint8_t& pixel = pixels[index_of({column, row})];
      const cv::Point block = blocks_->of_cell(box.tl() + cv::Point(column, row));
      const bool wanted = pixel != 0 || (all.contains(block) && blocks_->swept.all()(block) != 0);
      if (wanted) pixel |= kWanted;
    }
  }
  return pixels;
}

double Coverage::area() const {
  if (aim_) return coverage::area(*aim_);
  return blocks_ ? cell() * cell() * sum_of(blocks_->wanted) : 0;
}

double Coverage::covered() const {
  return blocks_ ? std::min(cell() * cell() * sum_of(blocks_->seen), area()) : 0;
}

double Coverage::seen() const {
  std::int64_t cells = 0;
  for (const Place& place : counts_.places())
    cells +=
        std::ranges::count_if(*counts_.at(place), [](std::uint8_t count) { return count > 0; });
  return cell() * cell() * static_cast<double>(cells);
}

double Coverage::covered(const Polygon& part) const {
  if (!blocks_) return 0;
  Polygon in_blocks = in_cells(part);
  for (Eigen::Vector2d& corner : in_blocks) corner /= blocks_->side;
  std::int64_t wanted = 0, seen = 0;
  for_spans(in_blocks, blocks_->frame, [&](int row, int first, int end) {
    const int y = row - blocks_->frame.y;
    for (int x = first - blocks_->frame.x; x < end - blocks_->frame.x; ++x) {
      wanted += blocks_->wanted(y, x);
      seen += blocks_->seen(y, x);
    }
  });
  return wanted > 0 ? static_cast<double>(seen) / static_cast<double>(wanted) : 0;
}

void Coverage::find_gaps() {
  const Blocks& blocks = *blocks_;
  gaps_.clear();
  for (const GapInBlocks& gap : gaps_in(cv::Mat1w(blocks.wanted - blocks.seen), blocks.side)) {
    // Of the block's cells the one next to its middle that is missing.
    const cv::Point corner = blocks.side * (gap.centre + blocks.frame.tl());
    const Place place = place_of(corner);
    const Pixels pixels = this->pixels(place);
    const cv::Point in_tile = corner - cells_of(place).tl();
    const double middle = 0.5 * (blocks.side - 1);
    std::optional<cv::Point> nearest;
    double least = 0;
    for (int y = 0; y < blocks.side; ++y) {
      for (int x = 0; x < blocks.side; ++x) {
        const std::size_t at = index_of(in_tile + cv::Point(x, y));
        const double distance = std::hypot(x - middle, y - middle);
        if (pixels[at] != kWanted || (nearest && distance >= least)) continue;
        nearest = corner + cv::Point(x, y);
        least = distance;
      }
    }
    const cv::Point cell_inside = nearest.value_or(corner);
    gaps_.push_back({cell() * Eigen::Vector2d(cell_inside.x + 0.5, -cell_inside.y - 0.5),
                     cell() * cell() * gap.cells});
  }
}

std::vector<Gap> Coverage::gaps(const Eigen::Vector2d& from, std::size_t most) const {
  std::vector<Gap> sorted = gaps_;
  const auto distance = [&](const Gap& gap) { return (gap.centre - from).squaredNorm(); };
  const std::size_t count = std::min(most, sorted.size());
  std::ranges::partial_sort(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(count), {},
                            distance);
  sorted.resize(count);
  return sorted;
}

}  // namespace nadir::coverage
