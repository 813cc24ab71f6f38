// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "guide.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core/mat.hpp>
#include <utility>

#include "nadir/image_io/encode.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector2d;

// A little less than their second and their fifth of one, so that images at 1 Hz are told of one by
// one.
constexpr auto kGuidancePeriod = 900ms, kMeasuresPeriod = 190ms, kWayPeriod = 190ms;
constexpr auto kDiskPeriod = 1s;
constexpr std::size_t kMostTiles = 256;  // at a time: of a large plan the rest comes a second later
constexpr std::size_t kMostGaps = 255;
constexpr double kLaneSpacing = 0.7;  // footprint widths: neighbours share three tenths
constexpr double kOther = 0.1;        // of a spacing, before lanes are laid out anew

std::optional<reference::UtmGrid> grid_of(const Config& config) {
  const auto origin = reference::parse_origin(config.reference.origin);
  return origin ? std::optional<reference::UtmGrid>(*origin) : std::nullopt;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

Guide::Guide(const Config& config)
    : config_(config),
      grid_(grid_of(config)),
      wanted_plan_(planned(config.plan, grid_)),
      gauges_(config),
      way_back_(static_cast<std::uint32_t>(config.odometry.weak_tie_points)) {}

void Guide::note(const Board& board) {
  const std::lock_guard lock(mutex_);
  board_ = board;
}

void Guide::plan(std::optional<coverage::Plan> plan) {
  const std::lock_guard lock(mutex_);
  wanted_plan_ = std::move(plan);
}

bool Guide::is_metric() const {
  return std::ranges::any_of(
      scales_, [](const auto& scale) { return scale.second.source != ScaleSource::none; });
}

void Guide::observe(const Orientation& orientation, const wire::LiveImage* live) {
  if (const Window* window = orientation.window.get()) {
    scales_.try_emplace(window->submap, window->scale);
    if (orientation.axes == SurveyAxes::none) north_ = window->axes == SurveyAxes::attitude;
  }
  if (orientation.axes != SurveyAxes::none) north_ = orientation.axes == SurveyAxes::attitude;
  gauges_.observe(orientation);
  way_back_.observe(orientation, live);
  moved_ = moved_ || orientation.shot != nullptr;
  take_plan();
  follow_lane();
}

void Guide::observe(const Cloud& cloud) {
  if (!cloud.grid) return;
  const auto footprint = coverage::footprint_of(*cloud.grid);
  if (!footprint) return;
  coverage_.add(*footprint);
  constexpr std::size_t kMostWidths = 4096;
  if (widths_.size() == kMostWidths) widths_.erase(widths_.begin(), widths_.begin() + 1024);
  widths_.push_back(footprint->width);
  ground_changed_ = true;
}

void Guide::observe(const Revision& revision) {
  for (const auto& [submap, scale] : revision.scales) scales_[submap] = scale;
  if (revision.corrections.empty()) return;
  coverage_.correct(revision.corrections);
  ground_changed_ = true;
}

void Guide::take_plan() {
  std::optional<coverage::Plan> plan;
  {
    const std::lock_guard lock(mutex_);
    plan = wanted_plan_;
  }
  // Until the map is in metres nobody knows where the plan's corners lie; with an origin it may be
  // meant by the earth's north, too.
  if (!is_metric() || (grid_ && !north_)) plan.reset();
  if (plan && plan->lane_spacing == 0) {
    plan->lane_spacing = kLaneSpacing * coverage_.footprint_width();
    const double before = plan_ ? plan_->lane_spacing : 0;
    if (std::abs(plan->lane_spacing - before) < kOther * before) plan->lane_spacing = before;
  }
  if (plan == plan_) return;
  plan_ = plan;
  lanes_ = plan_ ? coverage::lanes_of(*plan_) : std::vector<coverage::Lane>();
  keeper_ = {};
  lane_changed_ = ground_changed_ = true;
  coverage_.aim(plan_ ? std::optional(plan_->ground()) : std::nullopt);
}

Vector2d Guide::vehicle() const {
  const Corrections& corrections = coverage_.corrections();
  if (const auto reckoned = way_back_.reckoned(corrections)) return *reckoned;
  const ImagePose* newest = gauges_.newest();
  if (!newest) return Vector2d::Zero();
  const Eigen::Vector3d x_in_survey =
      corrections.at(newest->submap, newest->image) * newest->survey_from_camera.translation;
  return x_in_survey.head<2>();
}

void Guide::follow_lane() {
  constexpr int kNone = -1;
  const int before = on_lane_ ? on_lane_->lane : kNone;
  on_lane_.reset();
  if (plan_) {
    Vector2d velocity = Vector2d::Zero();
    if (const auto moving = gauges_.velocity()) {
      const ImagePose& newest = *gauges_.newest();
      const Similarity3 correction = coverage_.corrections().at(newest.submap, newest.image);
      velocity = (correction.rigid.rotation * *moving).head<2>();
    }
    on_lane_ = keeper_.observe(*plan_, lanes_.size(), vehicle(), velocity);
  }
  const int now = on_lane_ ? on_lane_->lane : kNone;
  lane_changed_ = lane_changed_ || now != before;
}

std::vector<wire::CoverageTile> Guide::tiles(std::size_t most) {
  std::vector<wire::CoverageTile> tiles;
  while (tiles.size() < most && !untold_tiles_.empty()) {
    const coverage::Place place = untold_tiles_.extract(untold_tiles_.begin()).value();
    coverage::Coverage::Pixels pixels = coverage_.pixels(place);
    constexpr int kSide = wire::CoverageTile::kCells;
    static_assert(kSide == coverage::Counts::kTileSide);
    const cv::Mat image(kSide, kSide, CV_8UC1, pixels.data());
    tiles.push_back({place.column, place.row, coverage_.cell(), image_io::encode_png(image)});
  }
  return tiles;
}

wire::Guidance Guide::guidance() const {
  wire::Guidance guidance{.area = coverage_.area(), .covered = coverage_.covered()};
  if (plan_) guidance.plan = plan_->ground();
  for (const coverage::Gap& gap : coverage_.gaps(vehicle(), kMostGaps))
    guidance.gaps.push_back({gap.centre, gap.area});
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const double covered = coverage_.covered(coverage::strip_of(*plan_, lanes_.size(), i));
    guidance.lanes.push_back({lanes_[i].from, lanes_[i].to, covered});
  }
  if (on_lane_) {
    guidance.lane = on_lane_->lane;
    guidance.off_lane = on_lane_->off;
  }
  return guidance;
}

wire::Measures Guide::measures(Clock::time_point now) {
  if (!disk_.empty() && disk_seen_.is_over(now, kDiskPeriod)) {
    disk_seen_.told = now;
    std::error_code error;
    const auto space = std::filesystem::space(disk_, error);
    free_bytes_ = error ? 0 : static_cast<double>(space.available);
  }
  Board board;
  {
    const std::lock_guard lock(mutex_);
    board = board_;
  }
  if (free_bytes_ > 0) board.free_bytes = free_bytes_;
  const Gauges::Limits limits{median(widths_), lanes_.empty() ? 0 : plan_->lane_spacing,
                              is_metric(), grid_ ? grid_->convergence() : 0};
  return gauges_.measures(coverage_.corrections(), board, limits);
}

Guide::Told Guide::tell(Clock::time_point now) {
  Told told;
  if (way_back_.is_lost() != lost_told_ ||
      (lost_told_ && moved_ && way_told_.is_over(now, kWayPeriod))) {
    way_told_.told = now;
    lost_told_ = way_back_.is_lost();
    told.last_view = way_back_.take_last_view();
    told.way_back = way_back_.way(coverage_.corrections(), coverage_.footprint_width());
  }
  if (moved_ && measures_told_.is_over(now, kMeasuresPeriod)) {
    measures_told_.told = now;
    told.measures = measures(now);
  }
  if (ground_changed_ && !untold_since_) untold_since_ = now;
  // An image's ground comes after its pose: what was left over and goes with the pose must not make
  // the ground wait.
  const bool fresh = ground_changed_ && ground_told_.is_over(now, kGuidancePeriod);
  const bool seen = fresh || (untold_since_ && now - *untold_since_ >= kGuidancePeriod);
  ground_changed_ = false;
  if (fresh) ground_told_.told = now;
  if (seen) {
    for (const coverage::Place& place : coverage_.update()) untold_tiles_.insert(place);
    told.tiles = tiles(kMostTiles);
    untold_since_ = untold_tiles_.empty() ? std::nullopt : std::optional(now);
  }
  if (seen || lane_changed_ || (moved_ && guidance_told_.is_over(now, kGuidancePeriod))) {
    guidance_told_.told = now;
    told.guidance = guidance();
    moved_ = lane_changed_ = false;
  }
  return told;
}

Guide::Told Guide::finish() {
  Told told;
  for (const coverage::Place& place : coverage_.update()) untold_tiles_.insert(place);
  told.tiles = tiles(untold_tiles_.size());
  told.guidance = guidance();
  return told;
}

}  // namespace nadir::app
