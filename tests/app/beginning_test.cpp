// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "beginning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "app/notify_socket.hpp"
#include "record/fake_disk.hpp"
#include "serve/raw_client.hpp"
#include "support/dive_folder.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using namespace support;
using record::FailingDisk;
using testing::HasSubstr;

constexpr const char* kCalibration =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 360\n"
    "camera_matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
    "  data: [500., 0., 319.5, 0., 500., 179.5, 0., 0., 1.]\n"
    "distortion_coefficients: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
    "  data: [0., 0., 0., 0., 0.]\n";

/// A service whose camera is not there.
class BeginningTest : public testing::Test {
 protected:
  static Config configured(const fs::path& folder) {
    fs::create_directories(folder);
    std::ofstream(folder / "camera.yml") << kCalibration;
    Config config;
    config.capture.calibration = folder / "camera.yml";
    config.capture.camera = "/dev/no-such-camera";
    config.record.dives = folder / "dives";
    config.serve.port = 0;
    return config;
  }

  std::vector<std::string> dives() const {
    std::vector<std::string> names;
    for (const auto& dive : fs::directory_iterator(config.record.dives))
      names.push_back(dive.path().filename());
    return names;
  }

  std::vector<Finding> page_shows() const {
    std::vector<Finding> findings;
    serve::RawClient viewer(server.port());
    viewer.join();
    for (const serve::Message& message : viewer.until(wire::kCaughtUpType)) {
      if (const auto found = wire::decode_check(message.bytes)) findings = found->findings;
    }
    return findings;
  }

  const fs::path folder = fresh_folder("beginning");
  const Config config = configured(folder);
  NotifySocket systemd;
  ServiceManager manager;
  Heartbeat heart{manager};
  serve::WebServer server{config.serve, {}};
  Publisher page{server.feed(), "live", 0};
  LiveCheck check{config};
  std::stop_source stop;
  Commands commands;
  Beginning beginning{config, manager, heart, page, check, commands, stop.get_token()};
  capture::CameraSource cameras{config.capture};
};

TEST_F(BeginningTest, DoesNotHangOnASlowCard) {
  struct SlowDisk : record::Disk {
    int sync(int) override { return std::this_thread::sleep_for(1500ms), 0; }
  } disk;
  heart.beat(1s);
  systemd.told();
  const auto begun = Heartbeat::Clock::now();
  EXPECT_TRUE(beginning.begin_dive(config, cameras, disk));
  ASSERT_GT(Heartbeat::Clock::now() - begun, 4s);
  EXPECT_GE(std::ranges::count(systemd.told(), "WATCHDOG=1"), 3);
}

TEST_F(BeginningTest, TriesUntilTheDiskTakesTheDive) {
  FailingDisk disk;
  int failures = 4;  // two of each try
  disk.verdict = [&](FailingDisk::Call call) {
    return call == FailingDisk::Call::write && failures-- > 0 ? -EROFS : 0;
  };
  Config mapping = config;
  mapping.sensors.magnetic_variation_deg = 2.5;
  const auto dive = beginning.begin_dive(mapping, cameras, disk);
  ASSERT_TRUE(dive);
  EXPECT_LT(failures, 0);

  const auto shown = page_shows();
  const auto finding = std::ranges::find(shown, "disk", &Finding::item);
  ASSERT_NE(finding, shown.end());
  EXPECT_EQ(finding->verdict, Verdict::bad);
  EXPECT_THAT(finding->found, HasSubstr("Read-only file system"));

  ASSERT_EQ(dives().size(), 1u) << "what was tried in vain is gone";
  EXPECT_THAT(dives()[0], testing::StartsWith("dive-0001"));
  EXPECT_TRUE(dive->finish({}).empty());
  const fs::path recorded = fs::path(config.record.dives) / dives()[0];
  EXPECT_EQ(dive_json(recorded)["configuration"]["sensors"]["magnetic_variation_deg"], 2.5);
  const std::string alerts = contents(recorded / "alerts.jsonl");
  EXPECT_THAT(alerts, HasSubstr("camera_lost"));
  const auto told = alerts.find("Read-only file system");
  ASSERT_NE(told, alerts.npos);
  EXPECT_EQ(alerts.find("Read-only file system", told + 1), alerts.npos) << "told once";
  EXPECT_NE(alerts.find("storage_back", told), alerts.npos) << "and that it is over";
}

TEST_F(BeginningTest, WaitsForAPageToBeginAnotherDive) {
  std::optional<PageCommand> given;
  std::jthread waiting([&] { given = beginning.wait_for_command(cameras); });
  const auto end = Heartbeat::Clock::now() + 10s;
  EXPECT_FALSE(commands.give(PageCommand::end_dive)) << "there is none to end";
  while (!commands.give(PageCommand::begin_dive) && Heartbeat::Clock::now() < end)
    std::this_thread::sleep_for(10ms);
  waiting.join();
  EXPECT_EQ(given, PageCommand::begin_dive);

  serve::WebServer other{config.serve, {}};
  Publisher fresh{other.feed(), "live", 0};
  beginning.show_on(fresh);
  serve::RawClient viewer(other.port());
  viewer.join();
  std::vector<std::string> alerts;
  for (const serve::Message& message : viewer.until(wire::kCaughtUpType)) {
    if (const auto told = wire::decode_alert(message.bytes)) alerts.push_back(told->alert.message);
  }
  ASSERT_EQ(alerts.size(), 1u) << "what was told meanwhile";
  EXPECT_THAT(alerts[0], HasSubstr("no-such-camera"));
}

TEST_F(BeginningTest, EndsItsWaitWhenToldTo) {
  std::jthread stopping([&] {
    std::this_thread::sleep_for(100ms);
    stop.request_stop();
  });
  EXPECT_EQ(beginning.wait_for_command(cameras), std::nullopt);
  EXPECT_FALSE(beginning.first_image(cameras));
  EXPECT_EQ(beginning.command(), std::nullopt);
}

}  // namespace
}  // namespace nadir::app
