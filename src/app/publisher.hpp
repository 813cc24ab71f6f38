// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Turns what the stages make into records of the browser protocol and hands them to the server.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "guide.hpp"
#include "live_dive.hpp"
#include "nadir/core/cloud.hpp"
#include "nadir/core/revision.hpp"
#include "nadir/core/tile.hpp"
#include "nadir/mosaic2d/overviews.hpp"
#include "nadir/serve/feed.hpp"
#include "nadir/wire/records.hpp"
#include "nadir/wire/tie_point_blocks.hpp"

namespace nadir::app {

/// A dive that record::give_again gives once more.
struct RecordedDive {
  std::string name;
};

/// One thread calls it; the viewers' counts are those of what it was given.
class Publisher {
 public:
  /// images_total 0: unknown. live: whose changes are published meanwhile, may be null. Both must
  /// outlive this.
  Publisher(std::shared_ptr<serve::Feed> feed, std::string input, std::uint64_t images_total,
            const Config& config = {}, LiveDive* live = nullptr);
  /// Without what concerns a diver of now: no dials, no rate, no way to swim.
  Publisher(std::shared_ptr<serve::Feed> feed, RecordedDive dive);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  void publish(const Orientation& orientation);
  /// From the next live image on. Any thread.
  void slow_down(bool slow) { slow_ = slow; }
  void publish(const Surface& surface);
  void publish(const Cloud& cloud);
  void publish(const MosaicUpdate& mosaic);
  /// As they lie on the disk, corrected; after all revisions.
  void publish_corrected(const MosaicGrid& grid,
                         const std::vector<std::shared_ptr<const Tile>>& tiles);
  /// Places again what a correction moves; no pixels.
  void publish(const Revision& revision);
  void publish(const Alert& alert);
  void publish(const Mark& mark);
  void publish(const std::vector<StageStats>& stages);
  void publish(const wire::Check& check);
  /// For the dials, see Guide. Any thread.
  void note(const Board& board) { guide_.note(board); }
  /// What is to be covered from now on, see Guide. Any thread.
  void plan(std::optional<coverage::Plan> plan) { guide_.plan(std::move(plan)); }
  /// Without somebody who notes its free space. Before all else.
  void watch_disk(const std::filesystem::path& folder) { guide_.watch_disk(folder); }
  /// The dive is mapped; dropped_at_end: images dropped after the last shot.
  void finish(std::uint64_t dropped_at_end);
  /// The recorded dive was given; captured: images in all.
  void finish_recorded(std::uint64_t captured);

 private:
  using Clock = std::chrono::steady_clock;

  template <class Record>
  void send(serve::Lane lane, const Record& record);
  void send_state();
  std::optional<wire::LiveImage> send_live_image(const Orientation& orientation);
  void send(Guide::Told told);
  void send_tiles(const std::vector<std::shared_ptr<const Tile>>& tiles);
  void send_overviews(std::size_t most);
  void send_overviews_in_time();
  void count_recorded(const Shot& shot);
  void send_corrected(const ImagePose& pose);
  void send_corrected(wire::PlaneGrid grid);
  void send_corrected(const wire::TiePoints& block);
  void send_corrected(const MosaicGrid& grid, std::uint64_t first_image);

  void send_corrected(Mark mark);

  const std::shared_ptr<serve::Feed> feed_;
  LiveDive* const live_;
  Guide guide_;
  std::optional<wire::Recording> recorded_;  ///< of a recorded dive
  wire::State state_;
  wire::TiePointBlocks tie_points_;
  // As odometry left them, to be sent again when corrected.
  std::map<std::uint64_t, ImagePose> poses_;
  std::map<std::uint64_t, wire::PlaneGrid> grids_;
  struct Seen {
    std::uint32_t submap = 0;
    std::uint64_t image = 0;
  };
  std::map<std::uint64_t, Seen> seen_;  ///< by block of tie points: where they were last adjusted
  std::map<std::uint32_t, std::pair<MosaicGrid, std::uint64_t>> mosaics_;  ///< first image
  std::map<std::uint64_t, Mark> marks_;  ///< as put, before their images' corrections
  Corrections corrections_;
  std::map<std::uint32_t, Scale> scales_;  ///< by sub-map, as corrected
  std::set<std::tuple<std::uint32_t, std::int32_t, std::int32_t>> tiles_;
  mosaic2d::Overviews overviews_;
  Clock::time_point overviews_sent_{};
  std::uint64_t alerts_ = 0;
  bool camera_sent_ = false;
  std::shared_ptr<const Window> window_;  ///< the last
  Clock::time_point live_sent_{};
  std::atomic<bool> slow_ = false;
  std::deque<std::pair<Clock::time_point, std::uint64_t>> recent_;  ///< images captured by then
};

}  // namespace nadir::app
