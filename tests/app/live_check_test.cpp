// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "live_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "dive_course.hpp"
#include "pause.hpp"
#include "support/dive_folder.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// Condition true within some seconds.
template <class Condition>
bool soon(Condition condition) {
  for (const auto end = LiveCheck::Clock::now() + 20s; LiveCheck::Clock::now() < end;) {
    if (condition()) return true;
    pause_for(5ms, {});
  }
  return false;
}

std::optional<Finding> item_of(const std::vector<Finding>& findings, const std::string& item) {
  const auto found = std::ranges::find(findings, item, &Finding::item);
  return found == findings.end() ? std::nullopt : std::optional(*found);
}

/// A dive whose camera gives an image when told to, and a clock that goes as the test says.
class LiveCheckTest : public testing::Test {
 protected:
  LiveCheckTest() {
    config.record.dives = folder;
    support::fs::create_directories(folder);
    auto rig = std::make_shared<CameraRig>();
    rig->left = {320, 240, 300, 300, 160, 120};
    frame.rig = rig;
    frame.grey.create(240, 320, CV_8UC1);
    cv::RNG(1).fill(frame.grey, cv::RNG::UNIFORM, 0, 255);
    cv::merge(std::vector(3, frame.grey), frame.colour);
  }
  ~LiveCheckTest() override { graph.reset(); }

  void begin_dive() {
    dive.emplace(folder / "dive", dive_info({}, "odometry", config), config.record);
    graph.emplace(config, Rate{Rate::Kind::live, 0},
                  Graph::Ends{[this](const std::stop_token& stop) { return next(stop); },
                              {},
                              {},
                              *dive,
                              nullptr,
                              progress});
  }

  std::optional<capture::Captured> next(const std::stop_token& stop) {
    if (!pause_for(1ms, stop)) return std::nullopt;
    if (given == wanted) return capture::Captured{};
    frame.image = given++;
    frame.time = monotonic_now();
    Shot shot;
    shot.image = frame.image;
    shot.time = frame.time;
    shot.frame = std::make_shared<const Frame>(frame);
    return capture::Captured{std::move(shot), {}};
  }

  void give(std::uint64_t images) {
    wanted += images;
    ASSERT_TRUE(soon([&] {
      return graph->shots().accepted + graph->shots().dropped == wanted && graph->newest();
    }));
  }

  /// Told by waiting(), or by mapping() when there is a graph.
  Finding of_disk(LiveCheck& check) {
    const Finding missing{Verdict::bad, "disk", "is read-only"};
    std::optional<Finding> found;
    soon([&] {
      now += 5s;
      const auto told =
          graph ? check.mapping(now, {}, *graph, {}) : check.waiting(now, {}, missing);
      found = item_of(told.value().findings, "disk speed");
      return found.has_value();
    });
    return found.value_or(missing);
  }

  /// What is told meanwhile, last.
  std::vector<Finding> map(LiveCheck& check, std::chrono::seconds time, std::uint64_t images_each) {
    std::vector<Finding> last;
    for (const auto end = now + time; now < end;) {
      now += 500ms;
      if (images_each > 0) give(images_each);
      if (const auto told = check.mapping(now, {}, *graph, {})) last = told->findings;
    }
    return last;
  }

  const support::fs::path folder = support::fresh_folder("live-check");
  Config config;
  Frame frame;
  std::atomic<std::uint64_t> wanted = 0;
  std::uint64_t given = 0;
  Progress progress{0, stderr};
  std::optional<record::Dive> dive;
  std::optional<Graph> graph;
  LiveCheck::Clock::time_point now = LiveCheck::Clock::now();
};

TEST_F(LiveCheckTest, MeasuresAgainADiskThatCouldNotBeWritten) {
  const support::fs::path mount = folder / "mount";
  std::ofstream(mount) << "no folder";
  config.record.dives = mount / "dives";
  LiveCheck check(config);
  EXPECT_EQ(of_disk(check).verdict, Verdict::bad);
  check.stop_measuring();
  support::fs::remove(mount);
  support::fs::create_directories(config.record.dives);
  begin_dive();
  EXPECT_TRUE(soon([&] { return of_disk(check).verdict != Verdict::bad; }));
}

TEST_F(LiveCheckTest, TellsOfACertificateThatCannotBeUsed) {
  const Finding missing{Verdict::bad, "camera", "is not there"};
  const auto plain = LiveCheck(config).waiting(now, {}, missing).value().findings;
  EXPECT_FALSE(item_of(plain, "https"));
  config.serve.certificate = config.serve.key = folder / "none.pem";
  const auto told = LiveCheck(config).waiting(now, {}, missing).value().findings;
  const auto https = item_of(told, "https");
  ASSERT_TRUE(https);
  EXPECT_EQ(https->verdict, Verdict::doubtful);
  EXPECT_THAT(https->found, HasSubstr("none.pem"));
}

TEST_F(LiveCheckTest, JudgesTheCameraByTheImagesThatCome) {
  begin_dive();
  LiveCheck check(config);
  // Of the first image there is no rate yet.
  give(1);
  const auto first = check.mapping(now, {}, *graph, {}).value().findings;
  EXPECT_FALSE(item_of(first, "camera"));
  EXPECT_TRUE(item_of(first, "exposure"));
  EXPECT_FALSE(check.image_rate_hz());

  const auto mapped = map(check, 5s, 5);
  EXPECT_EQ(item_of(mapped, "camera").value().found, "10.0 images a second");
  EXPECT_EQ(item_of(mapped, "camera").value().verdict, Verdict::good);
  EXPECT_TRUE(item_of(mapped, "exposure"));
  EXPECT_NEAR(check.image_rate_hz().value(), 10, 1e-9);
}

TEST_F(LiveCheckTest, SaysThatImagesHaveCeasedAndNothingOfTheLastPicture) {
  config.capture.rate_hz = 0;  // any
  begin_dive();
  LiveCheck check(config);
  map(check, 5s, 5);
  const auto unplugged = map(check, 10s, 0);
  EXPECT_EQ(item_of(unplugged, "camera").value().verdict, Verdict::bad);
  EXPECT_THAT(item_of(unplugged, "camera").value().found, HasSubstr("no image for"));
  for (const char* item : {"exposure", "focus", "sensors"})
    EXPECT_FALSE(item_of(unplugged, item)) << item;
  EXPECT_FALSE(check.image_rate_hz());

  const auto back = map(check, 10s, 5);
  EXPECT_EQ(item_of(back, "camera").value().verdict, Verdict::good);
  EXPECT_TRUE(item_of(back, "exposure"));
}

TEST_F(LiveCheckTest, TellsTheHeadingFromTrueNorthWhateverTheMapsGrid) {
  config.reference.origin = "43.296 5.37";
  frame.attitude = Attitude{0, 0, 29.0 / 180 * M_PI};
  begin_dive();
  config.sensors.inputs = "nmea:udp:2000";
  LiveCheck check(config);
  give(1);
  EXPECT_NEAR(graph->newest()->shot->frame->attitude->yaw, 27.4 / 180 * M_PI, 1e-3);
  const auto told = check.mapping(now, {}, *graph, {}).value().findings;
  EXPECT_THAT(item_of(told, "sensors").value().found, HasSubstr("heading 29 degrees"));
}

}  // namespace
}  // namespace nadir::app
