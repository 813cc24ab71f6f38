// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// doctor's findings of the service that holds the cameras, for the page. By one thread.
#pragma once

#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>

#include "graph.hpp"
#include "image_rate.hpp"
#include "ladder.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::app {

class LiveCheck {
 public:
  using Clock = std::chrono::steady_clock;

  /// Begins to measure the disk.
  explicit LiveCheck(const Config& config);
  ~LiveCheck();
  LiveCheck(const LiveCheck&) = delete;
  LiveCheck& operator=(const LiveCheck&) = delete;

  /// Every few seconds, none between. missing: for want of what there is no map.
  std::optional<wire::Check> waiting(Clock::time_point now, const Load& load,
                                     const Finding& missing);
  /// The same, to be called once or twice a second. skew: of a pair, as CameraSource tells it.
  std::optional<wire::Check> mapping(Clock::time_point now, const Load& load, const Graph& graph,
                                     std::optional<Time> skew);
  /// That the graph is given, as mapping() saw it; none before it can be told.
  std::optional<double> image_rate_hz() const { return image_rate_.hz(); }
  /// The disk belongs to the dive from now on. Whether one comes back that could not be written is
  /// still tried, with little.
  void stop_measuring() { enough_.request_stop(); }

 private:
  void measure_disk();
  bool is_due(Clock::time_point now);
  wire::Check of_board(const Load& load);
  const Finding& pair_of(const Frame& frame, Clock::time_point now);

  const Config config_;
  const double convergence_;  ///< with an origin frames' yaws are the grid's
  ImageRate image_rate_;
  std::optional<Clock::time_point> told_, pair_checked_;
  const std::vector<Finding> https_;
  std::stop_source enough_;  ///< measured of the disk
  std::future<Finding> disk_speed_to_come_;
  std::optional<Finding> disk_, pair_;
  std::jthread measuring_;
};

}  // namespace nadir::app
