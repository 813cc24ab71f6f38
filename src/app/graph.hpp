// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Who feeds whom: the whole machine on one page (paper 3.1).
//
//   sensors -+
//   capture -+-> odometry -> plane -+-> mosaic2d ----+-> record, page
//                     |              +-> projection3d -+
//                     +-> revisit -> record, page
//                     +-> record, page
//                     +-> outputs (poses; clouds from projection3d)
//
// Of live sources, sensors and capture send alerts that belong to no image to record, too.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <variant>
#include <vector>

#include "assembler.hpp"
#include "config.hpp"
#include "drop_rate.hpp"
#include "image_speed.hpp"
#include "ladder.hpp"
#include "live_dive.hpp"
#include "nadir/odometry/posed_images.hpp"
#include "nadir/pipeline/channel.hpp"
#include "nadir/pipeline/stage.hpp"
#include "nadir/sensors/listener.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "progress.hpp"
#include "publisher.hpp"

namespace nadir::app {

/// Images that found no room since the last that did, and what they had to tell.
struct Dropped {
  std::uint32_t images = 0;
  std::uint32_t missed = 0;  ///< by the camera, before and between them
  std::uint64_t last_image = 0;
  Time last_time = 0;
  std::vector<Alert> alerts;

  void add(std::uint64_t image, Time time, std::vector<Alert> own);
  /// Their alerts and one of how many they were, told with an image.
  std::vector<Alert> told(std::uint64_t image, Time time) const;
};

/// Runs from construction. Everything given must outlive it; page may be null.
class Graph {
 public:
  struct Ends {
    /// Waits for an image, a second at most; none at the end, or when told to stop.
    std::function<std::optional<capture::Captured>(const std::stop_token&)> capture;
    const std::optional<calibration::Lasers>& lasers;
    std::function<void(double)> note_speed;  ///< of images, see ImageSpeed; may be empty
    record::Dive& dive;
    Publisher* page;
    Progress& progress;
    LiveDive* live = nullptr;  ///< may be null
  };

  /// poses: in place of odometry.
  Graph(const Config& config, Rate rate, const Ends& ends, std::optional<GivenPoses> poses = {});

  ~Graph();

  /// A request ends the source; what was captured is still mapped. It may outlive the graph.
  std::stop_source stop_source() const { return stop_; }

  /// Waits until everything captured is mapped and recorded. What a stage threw, which ended the
  /// source, or null.
  std::exception_ptr join();

  /// Images dropped after the last that found room; after join().
  const Dropped& dropped_at_end() const { return dropped_; }

  /// UTC minus the time of images, as sensors told it; after join().
  std::optional<Time> utc_offset() const { return vehicle_.utc_offset(); }

  ImageFlow shots() const { return {shots_.accepted(), shots_.dropped()}; }

  /// Of every stage, for dive.json and the page.
  std::vector<StageStats> stats() const;
  /// Gives up what it says, until told otherwise, and tells the diver. By one thread.
  void economise(Economy economy, const std::string& reason, Time now);

  /// From the next image on; with given poses nothing. Any thread.
  void begin_submap() { submap_wanted_ = true; }

  /// The newest image and what odometry made of it; null before. Any thread.
  std::shared_ptr<const Orientation> newest() const { return newest_; }
  /// What was found of the equipment, for the page. By one thread.
  void show(const wire::Check& check);

  /// For the page's dials. UTC is as sensors tell it when the board does not know it. Any thread.
  void note(Board board);

  /// Of every stage but sensors, which waits for devices that may hang.
  std::vector<pipeline::StageActivity> activities() const;

 private:
  template <class T>
  using Shared = std::shared_ptr<const T>;
  template <class T>
  using Channel = pipeline::Channel<Shared<T>>;
  using Bell = std::shared_ptr<pipeline::Bell>;

  using Odometry = std::variant<odometry::VisualOdometry, odometry::PosedImages>;

  Odometry make_odometry(const odometry::Config& config, std::optional<GivenPoses> poses);
  template <class T, class Process>
  pipeline::Input feed(Channel<T>& channel, Process process);
  bool capture_one();
  void pass_on(Shot shot);
  bool listen();
  void hear(const sensors::Heard& heard);
  Shared<Shot> with_sensors(Shared<Shot> shot);
  void orient(Shared<Shot> shot);
  void pass_on(Orientation orientation);
  void fit(Shared<Orientation> orientation);
  void project(Shared<Surface> surface);
  void stitch(Shared<Surface> surface);
  void look_back(const Shared<Settlement>& settlement);
  void write(const record::Entry& entry);
  void keep(const Mark& mark);
  void tell(const Alert& alert);
  void publish_statistics();

  void start_stages();
  bool wait_for(const Shot& shot);
  template <class T>
  void to_page(Channel<T>& channel, const Shared<T>& message) {
    if (ends_.page) channel.push(message);
  }

  const Rate rate_;
  Ends ends_;
  const std::vector<sensors::Input> sensor_inputs_;
  sensors::VehicleState vehicle_;
  reference::SurveyFrame survey_;
  Odometry odometry_;
  plane::PlaneFit plane_;
  mosaic2d::Mosaicker mosaicker_;
  projection3d::PlaneProjection projection_;
  revisit::Revisit revisit_;
  ImageSpeed image_speed_;
  std::optional<Outputs> outputs_;  ///< of live images, when any are configured
  Assembler assembler_;

  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now(), told_ = begun_;
  std::uint64_t shots_taken_ = 0;
  std::optional<Time> first_time_;
  // What did not find room since the last message that did, to be told with the next.
  Dropped dropped_;
  std::uint32_t windows_skipped_ = 0, surfaces_skipped_ = 0;

  std::atomic<Economy> economy_ = Economy::none;
  std::uint64_t surfaces_projected_ = 0;
  static constexpr Time kUnknown = std::numeric_limits<Time>::min();
  std::atomic<Time> utc_offset_ = kUnknown;  ///< as sensors told it, of now
  std::stop_source stop_;
  std::atomic<bool> submap_wanted_ = false;
  std::atomic<bool> started_ = false;  ///< every stage exists
  std::atomic<Shared<Orientation>> newest_;

  Bell output_bell_ = std::make_shared<pipeline::Bell>(),
       odometry_bell_ = std::make_shared<pipeline::Bell>(),
       record_bell_ = std::make_shared<pipeline::Bell>(),
       page_bell_ = std::make_shared<pipeline::Bell>();
  Channel<sensors::Heard> readings_;
  Channel<Shot> shots_;
  Channel<Alert> capture_alerts_, sensor_alerts_, load_alerts_;
  Channel<Orientation> orientations_, recorded_orientations_, page_orientations_;
  Channel<Surface> projection_surfaces_, mosaic_surfaces_, recorded_surfaces_, page_surfaces_;
  Channel<Cloud> recorded_clouds_, page_clouds_;
  Channel<MosaicUpdate> recorded_mosaics_, page_mosaics_;
  Channel<Settlement> settlements_;
  Channel<Revision> recorded_revisions_, page_revisions_;
  Channel<Alert> page_alerts_;
  Channel<Mark> marks_, page_marks_;
  Channel<wire::Check> page_checks_;
  Channel<Orientation> output_orientations_;
  Channel<Cloud> output_clouds_;

  std::unique_ptr<pipeline::Stage> outputs_stage_, page_, record_, revisiting_, stitching_,
      projecting_, fitting_, orienting_, capture_, sensors_;
};

}  // namespace nadir::app
