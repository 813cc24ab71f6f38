// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "outputs.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

namespace nadir::app {
namespace {

class Receiver {
 public:
  Receiver() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~Receiver() { ::close(socket_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  std::string output() const { return "json:udp:127.0.0.1:" + std::to_string(port_); }
  nlohmann::json next() const {
    pollfd waiting{socket_, POLLIN, 0};
    constexpr int kPatience_ms = 1000;
    if (::poll(&waiting, 1, kPatience_ms) <= 0) return {};
    std::string bytes(65536, '\0');
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return nlohmann::json::parse(bytes);
  }

 private:
  int socket_;
  int port_ = 0;
};

Orientation found_at(const Eigen::Vector3d& position, Scale scale, SurveyAxes axes) {
  auto frame = std::make_shared<Frame>();
  frame->rig = std::make_shared<const CameraRig>();
  auto shot = std::make_shared<Shot>();
  shot->frame = frame;
  auto window = std::make_shared<Window>();
  window->scale = scale;
  window->axes = axes;
  Orientation orientation;
  orientation.shot = shot;
  orientation.poses.push_back({0, 0, 0, {Eigen::Quaterniond::Identity(), position}, true, 9, 0.3});
  orientation.window = window;
  return orientation;
}

TEST(Outputs, TellLatitudeAndLongitudeOfAMetricMapWithAnOriginAndNorth) {
  const Receiver receiver;
  Config config;
  config.sensors.outputs = receiver.output();
  config.reference.origin = "43.2965 5.3698 10";
  const Scale metric{ScaleSource::stereo, 0.001}, none;
  {
    Outputs outputs(config);
    outputs.process(found_at({0, 1000, 2}, metric, SurveyAxes::attitude));
    const auto told = receiver.next();
    // 1000 m along the grid's north, which is 1.6 degrees east of true north here.
    EXPECT_NEAR(told["latitude"].get<double>(), 43.2965 + 0.9996 * 1000 / 111'105, 1e-5);
    EXPECT_NEAR(told["longitude"].get<double>(), 5.3698 + 0.0281 * 1000 / 81'120, 1e-5);
    EXPECT_NEAR(told["grid_convergence_deg"].get<double>(), 1.63, 0.01);
  }
  for (const auto& [scale, axes] :
       {std::pair{none, SurveyAxes::attitude}, {metric, SurveyAxes::first_plane}}) {
    Outputs outputs(config);
    outputs.process(found_at({0, 0, 0}, scale, axes));
    const auto told = receiver.next();
    EXPECT_EQ(told["type"], "pose");
    EXPECT_FALSE(told.contains("latitude"));
  }
  config.reference.origin = "";
  Outputs outputs(config);
  outputs.process(found_at({0, 0, 0}, metric, SurveyAxes::attitude));
  const auto told = receiver.next();
  EXPECT_FALSE(told.contains("latitude"));
  EXPECT_FALSE(told.contains("grid_convergence_deg"));
}

/// A square metre of ground.
Cloud seen_at(double x, double y, Time time) {
  auto shot = std::make_shared<Shot>();
  shot->time = time;
  auto orientation = std::make_shared<Orientation>();
  orientation->shot = shot;
  auto surface = std::make_shared<Surface>();
  surface->orientation = orientation;
  surface->plane = Plane();
  Grid grid;
  grid.bgr = cv::Mat(2, 2, CV_8UC3, cv::Scalar(0));
  grid.survey_from_grid << 1, 0, x, 0, 1, y, 0, 0, 0, 0, 0, 1;
  grid.camera_in_survey = {x, y, 2};
  grid.max_range = 10;
  Cloud cloud;
  cloud.surface = surface;
  cloud.grid = grid;
  return cloud;
}

TEST(Outputs, TellWhatIsCoveredInADatagramHoweverRaggedItIs) {
  const Receiver receiver;
  Config config;
  config.sensors.outputs = receiver.output();
  Outputs outputs(config);
  constexpr int kSide = 45;  // of a chessboard's white fields, which make 300 kB
  constexpr Time kNext = 6'000'000'000;
  outputs.process(seen_at(0, 0, 0));
  EXPECT_EQ(receiver.next()["type"], "ground");
  EXPECT_EQ(receiver.next()["outline"].size(), 1u);
  for (int i = 1; i < kSide * kSide; ++i) {
    outputs.process(seen_at(2 * (i % kSide), 2 * (i / kSide), i == kSide * kSide - 1 ? kNext : 0));
    ASSERT_EQ(receiver.next()["type"], "ground") << i;
  }
  const auto told = receiver.next();
  ASSERT_EQ(told["type"], "coverage");
  double left = 1e9, right = -1e9;
  for (const auto& polygon : told["outline"]) {
    for (const auto& corner : polygon) {
      left = std::min(left, corner[0].get<double>());
      right = std::max(right, corner[0].get<double>());
    }
  }
  EXPECT_NEAR(left, 0, 2);
  EXPECT_NEAR(right, 2 * kSide - 1, 2);
}

}  // namespace
}  // namespace nadir::app
