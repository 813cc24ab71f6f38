// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Real datagrams, read back as an autopilot and a chart program would.
#include "nadir/sensors/pose_output.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "nadir/core/check.hpp"
#include "nadir/sensors/nmea.hpp"

namespace nadir::sensors {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

class Receiver {
 public:
  Receiver() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = std::to_string(ntohs(address.sin_port));
  }
  ~Receiver() { ::close(socket_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  std::string port() const { return port_; }
  /// The next datagram; empty when there is none.
  std::string next() const {
    pollfd waiting{socket_, POLLIN, 0};
    constexpr int kPatience_ms = 200;
    if (::poll(&waiting, 1, kPatience_ms) <= 0) return {};
    std::string bytes(65536, '\0');
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }

 private:
  int socket_;
  std::string port_;
};

// 30 degrees east of north, 10 nose up, 5 to the right: east-north-up from forward-right-down.
Pose tilted_pose() {
  const Eigen::Matrix3d survey_from_ned{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  const Eigen::Matrix3d ned_from_body = (Eigen::AngleAxisd(30 * kDegree, Eigen::Vector3d::UnitZ()) *
                                         Eigen::AngleAxisd(10 * kDegree, Eigen::Vector3d::UnitY()) *
                                         Eigen::AngleAxisd(5 * kDegree, Eigen::Vector3d::UnitX()))
                                            .toRotationMatrix();
  Pose pose;
  pose.time = 12'500'000'000;
  pose.image = 7;
  pose.submap = 2;
  pose.tracked = true;
  pose.position = {1, 2, -3};
  pose.survey_from_body = Eigen::Quaterniond(Eigen::Matrix3d(survey_from_ned * ned_from_body));
  pose.position_sigma = 0.02;
  pose.angle_sigma = 0.001;
  pose.metric = pose.north = true;
  return pose;
}

float float_at(const std::string& bytes, std::size_t at) {
  float value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

TEST(PoseOutput, SendsAPoseAsJson) {
  const Receiver receiver;
  PoseOutput output(parse_outputs("json:udp:127.0.0.1:" + receiver.port()), 1);
  Pose pose = tilted_pose();
  output.send(pose);
  json told = json::parse(receiver.next());
  EXPECT_EQ(told["type"], "pose");
  EXPECT_EQ(told["image"], 7);
  EXPECT_EQ(told["submap"], 2);
  EXPECT_EQ(told["time_s"], 12.5);
  EXPECT_EQ(told["tracked"], true);
  EXPECT_EQ(told["position"], json({1.0, 2.0, -3.0}));
  EXPECT_NEAR(told["heading_deg"].get<double>(), 30, 1e-9);
  EXPECT_NEAR(told["pitch_deg"].get<double>(), 10, 1e-9);
  EXPECT_NEAR(told["roll_deg"].get<double>(), 5, 1e-9);
  EXPECT_FALSE(told.contains("latitude"));
  pose.north = false;  // its axes are not the earth's
  pose.position_sigma = 0;
  output.send(pose);
  told = json::parse(receiver.next());
  EXPECT_FALSE(told.contains("heading_deg"));
  EXPECT_TRUE(told["position_sigma"].is_null());
}

TEST(PoseOutput, SendsAnAutopilotWhatItCanSteerBy) {
  const Receiver receiver;
  PoseOutput output(parse_outputs("mavlink:udp:127.0.0.1:" + receiver.port()), 3);
  Pose pose = tilted_pose();
  output.send(pose);
  const std::string heartbeat = receiver.next(), vision = receiver.next();
  constexpr std::size_t kHeader = 10;  // MAVLink 2
  ASSERT_GT(heartbeat.size(), kHeader);
  EXPECT_EQ(heartbeat[5], 3);
  EXPECT_EQ(heartbeat[7], 0);
  ASSERT_GT(vision.size(), kHeader + 32);
  EXPECT_EQ(vision[5], 3);
  EXPECT_EQ(vision[7], 102);
  // North, east, down, metres; roll, pitch, yaw.
  const std::array expected{2.0, 1.0, 3.0, 5 * kDegree, 10 * kDegree, 30 * kDegree};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(float_at(vision, kHeader + 8 + 4 * i), expected.at(i), 1e-6) << i;
  pose.time += 100'000'000;
  pose.submap = 3;  // its frame may have jumped
  output.send(pose);
  const std::string next = receiver.next();
  ASSERT_EQ(next.size(), kHeader + 117 + 2);
  EXPECT_EQ(next[kHeader + 116], 1);
  for (bool Pose::*needed : {&Pose::metric, &Pose::north, &Pose::tracked}) {
    Pose lacking = pose;
    lacking.*needed = false;
    output.send(lacking);
  }
  EXPECT_EQ(receiver.next(), "");
}

// The grid's north is 3 degrees east of true north: what is sent to others is by true north.
TEST(PoseOutput, OfAMapOnAGridTellsTrueNorth) {
  const Receiver receiver;
  PoseOutput json_output(parse_outputs("json:udp:127.0.0.1:" + receiver.port()), 1);
  PoseOutput mavlink_output(parse_outputs("mavlink:udp:127.0.0.1:" + receiver.port()), 1);
  Pose pose = tilted_pose();
  pose.convergence = 3 * kDegree;
  pose.position = {0, 100, -3};
  json_output.send(pose);
  const json told = json::parse(receiver.next());
  EXPECT_NEAR(told["heading_deg"].get<double>(), 33, 1e-9);
  EXPECT_NEAR(told["roll_deg"].get<double>(), 5, 1e-9);
  EXPECT_NEAR(told["grid_convergence_deg"].get<double>(), 3, 1e-9);
  EXPECT_EQ(told["position"], json({0.0, 100.0, -3.0}));
  mavlink_output.send(pose);
  receiver.next();  // the heartbeat
  const std::string vision = receiver.next();
  constexpr std::size_t kHeader = 10;
  ASSERT_GT(vision.size(), kHeader + 32);
  const std::array expected{100 * std::cos(3 * kDegree),
                            100 * std::sin(3 * kDegree),
                            3.0,
                            5 * kDegree,
                            10 * kDegree,
                            33 * kDegree};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(float_at(vision, kHeader + 8 + 4 * i), expected.at(i), 1e-5) << i;
}

TEST(PoseOutput, SendsSentencesThatChartsRead) {
  const Receiver receiver;
  PoseOutput output(parse_outputs("nmea:udp:127.0.0.1:" + receiver.port()), 1);
  Pose pose = tilted_pose();
  pose.geodetic = Position{-33.5 - 0.25 / 60, -0.125, {}};
  const std::string locale = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed
  output.send(pose);
  std::setlocale(LC_ALL, locale.c_str());
  const NmeaSentence heading = decode_nmea(receiver.next()),
                     position = decode_nmea(receiver.next());
  ASSERT_EQ(heading.fault, NmeaFault::none);
  EXPECT_NEAR(*heading.reading.heading, 30 * kDegree, 1e-4);
  EXPECT_EQ(position.kind, "GGA");
  pose.geodetic.reset();
  pose.north = false;
  output.send(pose);
  EXPECT_EQ(receiver.next(), "");
}

TEST(PoseOutput, SendsTheGroundAndWhatIsCovered) {
  const Receiver receiver;
  PoseOutput output(parse_outputs("json:udp:127.0.0.1:" + receiver.port()), 1);
  output.send(Ground{4, 1, {0, 0, 1}, {{0, 0, -2}, {1, 0, -2}, {1, 1, -2}, {0, 1, -2}}});
  json told = json::parse(receiver.next());
  EXPECT_EQ(told["type"], "ground");
  EXPECT_EQ(told["normal"], json({0.0, 0.0, 1.0}));
  EXPECT_EQ(told["footprint"].size(), 4u);
  EXPECT_TRUE(output.send(Outline{{{0, 0}, {2, 0}, {2, 1}}}));
  told = json::parse(receiver.next());
  EXPECT_EQ(told["type"], "coverage");
  EXPECT_EQ(told["outline"], json({{{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}}}));
}

TEST(PoseOutput, SaysWhenAnOutlineIsTooLongForADatagram) {
  const Receiver receiver;
  PoseOutput output(parse_outputs("json:udp:127.0.0.1:" + receiver.port()), 1);
  Outline outline{{}};
  for (int i = 0; i < 3000; ++i) outline[0].emplace_back(i / 3.0, i / 7.0);
  EXPECT_FALSE(output.send(outline));
  EXPECT_EQ(receiver.next(), "");
  while (!output.send(outline)) outline[0].pop_back();
  const std::string told = receiver.next();
  EXPECT_GT(told.size(), 59'900u);
  EXPECT_EQ(json::parse(told)["outline"][0].size(), outline[0].size());
}

TEST(PoseOutput, NeverWaitsForANetworkThatIsNotThere) {
  PoseOutput output(parse_outputs("json:udp:192.0.2.1:9 mavlink:udp:[2001:db8::1]:9"), 1);
  for (int i = 0; i < 1000; ++i) output.send(tilted_pose());
}

TEST(ParseOutputs, RefusesWhatCannotBeSentTo) {
  EXPECT_TRUE(parse_outputs("  ").empty());
  for (const auto& [text, fault] :
       std::vector<std::pair<std::string, std::string>>{{"xml:udp:127.0.0.1:9", "json:"},
                                                        {"json", "json:"},
                                                        {"json:tcp:127.0.0.1:9", "udp:"},
                                                        {"json:udp:127.0.0.1", "port"},
                                                        {"json:udp:127.0.0.1:0", "port"},
                                                        {"json:udp:127.0.0.1:70000", "port"},
                                                        {"json:udp:autopilot:9", "IP address"}}) {
    try {
      parse_outputs(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(fault)) << text;
    }
  }
}

}  // namespace
}  // namespace nadir::sensors
