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

}  // namespace
}  // namespace nadir::app
