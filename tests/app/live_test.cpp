// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The live machine from camera to disk, with real sockets for sensors and outputs; the camera's
// place is taken by a simulated survey at a camera's rate.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "dive_course.hpp"
#include "live_check.hpp"
#include "nadir/capture/folder_source.hpp"
#include "nadir/sensors/nmea.hpp"
#include "nadir/simulate/write_survey.hpp"
#include "pause.hpp"
#include "support/dive_folder.hpp"
#include "watch.hpp"

namespace nadir::app {
namespace {

using namespace std::chrono_literals;
using namespace support;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr int kImages = 14;
#ifdef NADIR_SLOW
constexpr Time kPeriod = 3'000'000'000;  // sanitized or emulated
#else
constexpr Time kPeriod = 200'000'000;
#endif

class Datagrams {
 public:
  Datagrams() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = at(0);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~Datagrams() { ::close(socket_); }
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;

  std::uint16_t port() const { return port_; }
  void send(const std::string& text, std::uint16_t to) const {
    const sockaddr_in address = at(to);
    ::sendto(socket_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&address),
             sizeof address);
  }
  std::vector<std::string> received() const {
    std::vector<std::string> all;
    for (pollfd waiting{socket_, POLLIN, 0}; ::poll(&waiting, 1, 0) > 0;) {
      std::string bytes(65536, '\0');
      const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
      bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
      all.push_back(std::move(bytes));
    }
    return all;
  }

 private:
  static sockaddr_in at(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  int socket_;
  std::uint16_t port_ = 0;
};

/// The images of a survey as a camera would give them: now, one a period, the first after a word of
/// a camera that was looked for; the camera then lost two and goes on until told to stop.
class SimulatedCamera {
 public:
  explicit SimulatedCamera(const fs::path& survey) : source_(survey, std::nullopt, {}) {}

  std::optional<capture::Captured> next(const std::stop_token& stop) {
    if (!std::exchange(told_, true)) {
      return capture::Captured{{},
                               {{monotonic_now(), std::nullopt, AlertKind::camera_lost,
                                 "camera: is looked for", "none needed"}}};
    }
    due_ += std::chrono::nanoseconds(kPeriod);
    if (!pause_until(due_, stop)) return std::nullopt;
    std::optional<Shot> shot = source_.next();
    if (!shot) return capture::Captured{};  // as a camera that has no image yet
    constexpr std::uint64_t kMissedAt = 5;
    if (shot->image == kMissedAt) missed_ = shot->missed_before = 2;
    shot->time = monotonic_now();
    shot->image += missed_;
    Frame frame = *shot->frame;
    frame.time = shot->time;
    frame.image = shot->image;
    frame.attitude.reset();  // the sensors' to tell
    frame.altitude.reset();
    frame.depth.reset();
    shot->frame = std::make_shared<const Frame>(std::move(frame));
    return capture::Captured{std::move(shot), {}};
  }
  const std::optional<calibration::Lasers>& lasers() const { return source_.lasers(); }

 private:
  capture::FolderSource source_;
  bool told_ = false;
  std::uint32_t missed_ = 0;
  Clock::time_point due_ = Clock::now();
};

// A level vehicle that heads north and sinks.
void tell_attitude(const Datagrams& sensor, std::uint16_t to, double depth) {
  sensor.send(sensors::nmea_line("HEHDT,000.0,T"), to);
  sensor.send(sensors::nmea_line("YXXDR,A,0.5,D,ROLL,A,-0.5,D,PITCH"), to);
  sensor.send(sensors::nmea_line("YXXDR,D," + std::to_string(depth) + ",M,DEPTH"), to);
}

TEST(Live, MapsWhatACameraSeesWithWhatSensorsSayAndTellsOthers) {
  cv::setNumThreads(1);
  const fs::path survey = fresh_folder("survey"), folder = fresh_folder("dive");
  simulate::Options options;
  options.stereo = true;
  options.images = kImages;
  options.image_scale = 0.5;
  simulate::write_survey(survey, options, {});

  const Datagrams sensor, chart;
  std::uint16_t listening = 0;
  {
    const Datagrams free;  // its port is free in a moment
    listening = free.port();
  }
  Config config;
  config.record.dives = fresh_folder("dives");
  config.sensors.inputs = "nmea:udp:127.0.0.1:" + std::to_string(listening);
  config.sensors.outputs = "json:udp:127.0.0.1:" + std::to_string(chart.port());
  const std::jthread talking([&](const std::stop_token& stop) {
    for (double depth = 3; !stop.stop_requested(); depth += 0.001) {
      tell_attitude(sensor, listening, depth);
      std::this_thread::sleep_for(20ms);
    }
  });

  SimulatedCamera camera(survey);
  std::atomic<double> fastest = 0;
  record::Dive dive(folder, dive_info({{"camera", "simulated"}}, "odometry", config),
                    config.record);
  Progress progress(0, stderr);
  LiveDive live;
  live.begin(folder);
  int status = -1;
  Watch watch;
  std::vector<Finding> equipment;
  {
    Graph graph(config, {Rate::Kind::live, 0},
                {[&](const std::stop_token& stop) { return camera.next(stop); }, camera.lasers(),
                 [&](double px) { fastest = std::max(fastest.load(), px); }, dive, nullptr,
                 progress, &live});
    const auto begun = Clock::now();
    std::this_thread::sleep_for(std::chrono::nanoseconds(kPeriod * (kImages / 2)));
    graph.economise(Economy::mosaic, "a test", monotonic_now());
    EXPECT_EQ(live.add({.position = {1, 2, -3}, .note = "an anchor"}), 0u);
    while (Clock::now() - begun < std::chrono::nanoseconds(kPeriod * (kImages + 4))) {
      EXPECT_EQ(watch.hung(Clock::now(), graph.activities()), std::nullopt);
      std::this_thread::sleep_for(50ms);
    }
    LiveCheck check(config);
    equipment = check.mapping(Clock::now(), {}, graph, from_seconds(0.001)).value().findings;
    EXPECT_EQ(check.mapping(Clock::now(), {}, graph, {}), std::nullopt);  // told just now
    graph.stop_source().request_stop();
    status = finish_dive({graph, dive, nullptr, progress, begun, &live});
    EXPECT_EQ(live.add({}), std::nullopt) << "the dive has ended";
  }
  EXPECT_EQ(status, 0);
  EXPECT_FALSE(live.now().is_recording);
  EXPECT_EQ(live.now().saved, kImages);
  EXPECT_NE(contents(folder / "marks.jsonl").find("an anchor"), std::string::npos);

  const json told = dive_json(folder);
  const json& counts = told["counts"];
  EXPECT_EQ(counts["captured"], kImages + 2);
  EXPECT_EQ(counts["dropped"]["camera"], 2);
  EXPECT_EQ(counts["dropped"]["storage"], 0);
  EXPECT_EQ(counts["captured"].get<int>(), counts["oriented"].get<int>() +
                                               counts["lost"].get<int>() +
                                               counts["dropped"]["camera"].get<int>() +
                                               counts["dropped"]["queue_full"].get<int>());
  EXPECT_EQ(told["survey_axes"], "attitude");
  EXPECT_EQ(told["scale"]["source"], "stereo");
  EXPECT_GT(fastest, 10);  // px a second
  EXPECT_LT(fastest, 2000);

  std::map<std::string, Verdict> verdicts;
  for (const Finding& finding : equipment) verdicts[finding.item] = finding.verdict;
  for (const char* item : {"exposure", "focus", "stereo skew", "stereo calibration", "sensors"}) {
    ASSERT_TRUE(verdicts.contains(item)) << item;
    EXPECT_EQ(verdicts[item], Verdict::good) << item;
  }

  const std::string alerts = contents(folder / "alerts.jsonl");
  for (const char* kind : {"camera_lost", "load"})
    EXPECT_NE(alerts.find(kind), std::string::npos) << kind;
  // The coarser mosaic is one of its own.
  EXPECT_TRUE(fs::exists(folder / "mosaic2d/mosaic-001.png"));

  std::map<std::string, int> types;
  bool north = false;
  for (const std::string& text : chart.received()) {
    const json object = json::parse(text);
    ++types[object["type"]];
    north = north || (object["type"] == "pose" && object["north"] == true &&
                      object["metric"] == true && object["tracked"] == true);
  }
  EXPECT_GE(types["pose"], counts["oriented"].get<int>() / 2);
  EXPECT_GE(types["ground"], 1);
  EXPECT_GE(types["coverage"], 1);
  EXPECT_TRUE(north);
}

}  // namespace
}  // namespace nadir::app
