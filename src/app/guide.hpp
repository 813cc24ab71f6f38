// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a diver must know to cover the ground: how often it was seen, gaps, lanes, the dials, and
// the way back when tracking is lost.
#pragma once

#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "config.hpp"
#include "gauges.hpp"
#include "nadir/core/cloud.hpp"
#include "nadir/coverage/coverage.hpp"
#include "way_back.hpp"

namespace nadir::app {

/// One thread calls it, but for what says otherwise.
class Guide {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Guide(const Config& config);

  /// live: the orientation's image as the page was shown it; null when it was not.
  void observe(const Orientation& orientation, const wire::LiveImage* live);
  void observe(const Cloud& cloud);
  void observe(const Revision& revision);

  /// Any thread.
  void note(const Board& board);
  /// What is to be covered from now on; none: the ground swept. It waits for a scale, and with
  /// reference.origin for an AHRS, too. Any thread.
  void plan(std::optional<coverage::Plan> plan);
  /// Measures the free space of a folder's disk itself. Before all else.
  void watch_disk(std::filesystem::path folder) { disk_ = std::move(folder); }

  /// Records whose time has come.
  struct Told {
    std::vector<wire::CoverageTile> tiles;
    std::optional<wire::Guidance> guidance;
    std::optional<wire::Measures> measures;
    std::optional<wire::LastView> last_view;
    std::optional<wire::WayBack> way_back;
  };
  Told tell(Clock::time_point now);
  /// All that is left to tell.
  Told finish();

 private:
  struct Period {
    std::optional<Clock::time_point> told;
    bool is_over(Clock::time_point now, Clock::duration period) const {
      return !told || now - *told >= period;
    }
  };

  bool is_metric() const;
  void take_plan();
  void follow_lane();
  Eigen::Vector2d vehicle() const;
  std::vector<wire::CoverageTile> tiles(std::size_t most);
  wire::Guidance guidance() const;
  wire::Measures measures(Clock::time_point now);

  const Config config_;
  const std::optional<reference::UtmGrid> grid_;  ///< with reference.origin
  std::filesystem::path disk_;

  std::mutex mutex_;  ///< of the next two
  Board board_;
  std::optional<coverage::Plan> wanted_plan_;

  coverage::Coverage coverage_;
  Gauges gauges_;
  WayBack way_back_;
  std::optional<coverage::Plan> plan_;  ///< in force
  std::vector<coverage::Lane> lanes_;
  coverage::LaneKeeper keeper_;
  std::optional<coverage::LaneKeeper::OnLane> on_lane_;
  std::vector<double> widths_;             ///< of footprints, as odometry left them
  std::map<std::uint32_t, Scale> scales_;  ///< by sub-map
  bool north_ = false;                     ///< survey y
  double free_bytes_ = 0;

  std::set<coverage::Place> untold_tiles_;
  std::optional<Clock::time_point> untold_since_;  ///< something of the ground
  bool moved_ = false, ground_changed_ = false, lane_changed_ = false, lost_told_ = false;
  Period ground_told_, guidance_told_, measures_told_, way_told_, disk_seen_;
};

}  // namespace nadir::app
