// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "recorded_feeds.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "nadir/core/check.hpp"
#include "nadir/record/recorded.hpp"
#include "publisher.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kUnwatchedPause = 50ms;  // between two images that nobody waits for
constexpr auto kLook = 200ms;           // between two looks whether somebody watches
constexpr std::size_t kMostEnding = 2;  // at the lowest priority they may take a while

// Changes when the dive was recovered since.
using Stamp = std::array<fs::file_time_type, 2>;
Stamp stamp_of(const fs::path& dive) {
  Stamp stamp{};
  std::error_code error;
  stamp[0] = fs::last_write_time(dive / "dive.json", error);
  if (error) stamp[0] = {};
  stamp[1] = fs::last_write_time(dive / "mosaic2d", error);
  if (error) stamp[1] = {};
  return stamp;
}

std::string several(std::uint64_t number, const std::string& thing) {
  return std::to_string(number) + ' ' + thing + (number == 1 ? "" : "s");
}

}  // namespace

/// One dive, its feed, and the thread that fills the one from the other. The thread holds the feed:
/// with its end the memory is free.
class RecordedFeeds::Reading {
 public:
  Reading(fs::path dive, const std::shared_ptr<serve::Feed>& feed, Clock::duration unwatched)
      : dive_(std::move(dive)),
        stamp_(stamp_of(dive_)),
        unwatched_(unwatched),
        feed_(feed),
        thread_([this, held = feed]() mutable { run(std::move(held)); }) {}
  ~Reading() { end(); }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

  bool is_of(const fs::path& dive) const { return dive == dive_; }
  bool is_current() const { return stamp_ == stamp_of(dive_); }
  void end() { stop_.request_stop(); }
  bool is_ending() const { return stop_.stop_requested(); }
  bool has_ended() const { return ended_; }
  /// Null once it ends.
  std::shared_ptr<serve::Feed> feed() const { return is_ending() ? nullptr : feed_.lock(); }

 private:
  void run(std::shared_ptr<serve::Feed> feed) {
    pthread_setname_np(pthread_self(), "recorded");
    constexpr int kLowest = 19;
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowest);
    try {
      give(feed);
    } catch (const std::exception& fault) {  // short of memory: not even an alert
      std::fprintf(stderr, "%s: %s\n", dive_.c_str(), fault.what());
      end();
    }
    while (!is_ending()) pause(*feed, kLook);
    feed.reset();
    ended_ = true;
  }

  // What is said after the end is of the reading, not of the dive.
  void give(const std::shared_ptr<serve::Feed>& feed) {
    Publisher page(feed, RecordedDive{dive_.filename().string()});
    try {
      const record::GivenAgain given = read(*feed, page);
      if (is_ending()) return;
      page.finish_recorded(given.captured);
      for (const Alert& alert : faults(given)) page.publish(alert);
    } catch (const std::exception& fault) {
      page.finish_recorded(0);
      page.publish(alert(fault.what(), "tells what is left"));
    }
  }

  record::GivenAgain read(const serve::Feed& feed, Publisher& page) {
    const auto entry = [&](const record::Entry& given) {
      page.publish(*given.orientation);
      if (given.cloud) page.publish(*given.cloud);
      for (const auto& revision : given.revisions) page.publish(*revision);
      if (given.orientation->shot) time_ = given.orientation->shot->time;
      keep_pace(feed);
    };
    const auto mosaic = [&](const MosaicGrid& grid, const auto& tiles) {
      page.publish_corrected(grid, tiles);
      keep_pace(feed);
    };
    const auto mark = [&](const Mark& given) { page.publish(given); };
    return record::give_again(dive_, {entry, mosaic, mark}, stop_.get_token());
  }

  std::vector<Alert> faults(const record::GivenAgain& given) const {
    const std::string name = dive_.filename().string();
    std::vector<Alert> faults;
    if (given.missing_records > 0) {
      faults.push_back(alert(name + ": " + several(given.missing_records, "record") +
                                 " of its journal damaged; the "
                                 "rest is shown",
                             "tells what is left"));
    }
    if (given.mosaics_left_out > 0) {
      faults.push_back(alert(name + ": " + several(given.mosaics_left_out, "mosaic") +
                                 " missing or damaged on the disk; the rest is shown",
                             "makes them again"));
    }
    if (given.captured_once) {  // the gravest last: that one stands across the screen
      faults.push_back(alert(name + ": the end of its journal is missing; images left: " +
                                 std::to_string(given.captured) + " of " +
                                 std::to_string(*given.captured_once),
                             "tells what is left"));
    }
    return faults;
  }

  Alert alert(const std::string& message, const std::string& what_recover_does) const {
    return {time_, std::nullopt, AlertKind::storage, message,
            "nadir recover " + dive_.string() + ' ' + what_recover_does};
  }

  void keep_pace(const serve::Feed& feed) {
    if (feed.viewers() > 0) {
      watched_ = Clock::now();
    } else {
      pause(feed, kUnwatchedPause);
    }
  }

  // Ends it all when nobody has watched for long.
  void pause(const serve::Feed& feed, Clock::duration time) {
    std::unique_lock lock(mutex_);
    woken_.wait_for(lock, stop_.get_token(), time, [] { return false; });
    if (feed.viewers() > 0) watched_ = Clock::now();
    if (Clock::now() - watched_ > unwatched_) end();
  }

  const fs::path dive_;
  const Stamp stamp_;
  const Clock::duration unwatched_;
  const std::weak_ptr<serve::Feed> feed_;
  std::stop_source stop_;
  std::atomic<bool> ended_ = false;
  // Of the thread.
  std::mutex mutex_;
  std::condition_variable_any woken_;
  Clock::time_point watched_ = Clock::now();
  Time time_ = 0;
  std::jthread thread_;
};

RecordedFeeds::RecordedFeeds(Clock::duration unwatched) : unwatched_(unwatched) {}

RecordedFeeds::~RecordedFeeds() {
  for (const auto& reading : readings_) reading->end();  // all at once
}

void RecordedFeeds::make_by(MakeFeed make) {
  const std::scoped_lock lock(mutex_);
  make_ = std::move(make);
}

std::shared_ptr<serve::Feed> RecordedFeeds::find(const fs::path& dive) {
  std::erase_if(readings_, [](const auto& reading) { return reading->has_ended(); });
  const auto known = std::ranges::find_if(readings_, [&](const auto& reading) {
    return reading->is_of(dive) && !reading->is_ending();
  });
  if (known != readings_.end() && !(*known)->is_current()) (*known)->end();
  if (auto feed = known != readings_.end() ? (*known)->feed() : nullptr) {
    std::rotate(known, std::next(known), readings_.end());
    return feed;
  }
  if (!make_room()) return nullptr;
  std::shared_ptr<serve::Feed> feed;
  {
    const std::scoped_lock lock(mutex_);
    if (make_) feed = make_();
  }
  if (feed) readings_.push_back(std::make_unique<Reading>(dive, feed, unwatched_));
  return feed;
}

bool RecordedFeeds::make_room() {
  const auto is_open = [](const auto& reading) { return !reading->is_ending(); };
  const auto open = static_cast<std::size_t>(std::ranges::count_if(readings_, is_open));
  if (readings_.size() - open > kMostEnding) return false;
  if (open < kMost) return true;
  const auto unwatched = std::ranges::find_if(readings_, [](const auto& reading) {
    const auto feed = reading->feed();
    return feed && feed->viewers() == 0;
  });
  if (unwatched == readings_.end()) return false;
  (*unwatched)->end();
  return true;
}

void RecordedFeeds::close(const fs::path& dive) {
  for (const auto& reading : readings_) {
    if (reading->is_of(dive)) reading->end();
  }
}

}  // namespace nadir::app
