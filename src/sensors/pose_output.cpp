// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/pose_output.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <utility>

#include "angle.hpp"
#include "nadir/core/check.hpp"
#include "nadir/sensors/mavlink.hpp"
#include "nadir/sensors/nmea.hpp"
#include "words.hpp"

namespace nadir::sensors {
namespace {

using nlohmann::json;

constexpr Time kSecond = 1'000'000'000;
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kMostBytes = 60'000;  // of a datagram: 65'507 by UDP over IPv4
constexpr std::array<std::string_view, 3> kProtocols{"json", "mavlink", "nmea"};

[[noreturn]] void refuse(std::string_view text, const std::string& fault) {
  throw InputError("output \"" + std::string(text) + "\": " + fault +
                   "; give json, mavlink or nmea, then udp:ADDRESS:PORT, such as "
                   "mavlink:udp:192.168.2.1:14550");
}

struct Destination {
  sockaddr_storage address{};
  socklen_t size = 0;
};

std::optional<Destination> destination_of(const std::string& address, std::uint16_t port) {
  Destination found;
  auto* const four = reinterpret_cast<sockaddr_in*>(&found.address);
  auto* const six = reinterpret_cast<sockaddr_in6*>(&found.address);
  if (inet_pton(AF_INET, address.c_str(), &four->sin_addr) == 1) {
    four->sin_family = AF_INET;
    four->sin_port = htons(port);
    found.size = sizeof *four;
    return found;
  }
  if (inet_pton(AF_INET6, address.c_str(), &six->sin6_addr) == 1) {
    six->sin6_family = AF_INET6;
    six->sin6_port = htons(port);
    found.size = sizeof *six;
    return found;
  }
  return std::nullopt;
}

Output parse_output(std::string_view text) {
  Output output;
  const std::size_t first = text.find(':');
  const auto protocol = std::ranges::find(kProtocols, text.substr(0, first));
  if (first == text.npos || protocol == kProtocols.end())
    refuse(text, "does not begin with json:, mavlink: or nmea:");
  output.protocol = static_cast<OutputProtocol>(protocol - kProtocols.begin());
  std::string_view rest = text.substr(first + 1);
  constexpr std::string_view kUdp = "udp:";
  if (!rest.starts_with(kUdp)) refuse(text, "does not go by udp:");
  rest.remove_prefix(kUdp.size());
  const std::size_t colon = rest.rfind(':');
  const std::string_view digits = colon == rest.npos ? "" : rest.substr(colon + 1);
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, output.port);
  if (error != std::errc() || stop != end || output.port == 0)
    refuse(text, "ends in no port from 1 to 65535");
  std::string_view address = rest.substr(0, colon);
  if (address.starts_with('[') && address.ends_with(']'))
    address = address.substr(1, address.size() - 2);
  output.address = address;
  if (!destination_of(output.address, output.port)) refuse(text, "names no IP address");
  return output;
}

/// A socket that never waits.
class Sender {
 public:
  explicit Sender(const Output& output)
      : protocol(output.protocol),
        destination_(*destination_of(output.address, output.port)),
        socket_(::socket(destination_.address.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC,
                         0)) {
    const int yes = 1;
    ::setsockopt(socket_, SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
  }
  ~Sender() {
    if (socket_ >= 0) ::close(socket_);
  }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void send(const void* bytes, std::size_t size) const {
    ::sendto(socket_, bytes, size, MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&destination_.address), destination_.size);
  }

  const OutputProtocol protocol;

 private:
  Destination destination_;
  int socket_;
};

json as_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Survey is east-north-up, but for the convergence.
Eigen::Matrix3d ned_from_survey(const Pose& pose) {
  const Eigen::Matrix3d grid_ned{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  return Eigen::AngleAxisd(pose.convergence, Eigen::Vector3d::UnitZ()) * grid_ned;
}

// Roll, pitch and yaw of body (FRD) to north-east-down.
Attitude attitude_of(const Pose& pose) {
  const Eigen::Matrix3d r = ned_from_survey(pose) * pose.survey_from_body.toRotationMatrix();
  return {std::atan2(r(2, 1), r(2, 2)), -std::asin(std::clamp(r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

std::string pose_json(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.survey_from_body;
  json object{{"type", "pose"},
              {"time_s", seconds(pose.time)},
              {"image", pose.image},
              {"submap", pose.submap},
              {"tracked", pose.tracked},
              {"position", as_json(pose.position)},
              {"survey_from_body", {q.x(), q.y(), q.z(), q.w()}},
              {"position_sigma", pose.position_sigma > 0 ? json(pose.position_sigma) : json()},
              {"angle_sigma_rad", pose.angle_sigma > 0 ? json(pose.angle_sigma) : json()},
              {"metric", pose.metric},
              {"north", pose.north}};
  if (pose.north) {
    const Attitude attitude = attitude_of(pose);
    object["roll_deg"] = attitude.roll / kDegree;
    object["pitch_deg"] = attitude.pitch / kDegree;
    object["heading_deg"] = as_heading(attitude.yaw) / kDegree;
    if (pose.convergence != 0) object["grid_convergence_deg"] = pose.convergence / kDegree;
  }
  if (pose.geodetic) {
    object["latitude"] = pose.geodetic->latitude_deg;
    object["longitude"] = pose.geodetic->longitude_deg;
  }
  return object.dump();
}

std::string formatted(const char* format, auto... values) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

// ddmm.mmmmmm and the hemisphere; snprintf would write a comma in some locales, integers do not.
std::string nmea_angle(double degrees, int whole_digits, const char* hemispheres) {
  constexpr double kMicrominutes = 60e6;
  const auto total = static_cast<long long>(std::llround(std::abs(degrees) * kMicrominutes));
  const long long whole = total / 60'000'000, rest = total % 60'000'000;
  return formatted("%0*lld%02lld.%06lld,%c", whole_digits, whole, rest / 1'000'000,
                   rest % 1'000'000, hemispheres[degrees < 0 ? 1 : 0]);
}

std::string heading_line(const Pose& pose) {
  constexpr long long kTurn_cdeg = 36000;
  const double heading = as_heading(attitude_of(pose).yaw) / kDegree;
  const long long hundredths = std::llround(100 * heading) % kTurn_cdeg;
  return nmea_line(formatted("IIHDT,%lld.%02lld,T", hundredths / 100, hundredths % 100));
}

// Estimated (quality 6), since no satellite is seen under water; without UTC the time is left out.
std::string position_line(const Position& position) {
  return nmea_line("IIGGA,," + nmea_angle(position.latitude_deg, 2, "NS") + ',' +
                   nmea_angle(position.longitude_deg, 3, "EW") + ",6,00,,,M,,M,,");
}

}  // namespace

std::vector<Output> parse_outputs(std::string_view text) {
  std::vector<Output> outputs;
  for (const std::string_view word : words_of(text)) outputs.push_back(parse_output(word));
  return outputs;
}

struct PoseOutput::State {
  void send(OutputProtocol protocol, std::span<const std::uint8_t> bytes) const {
    for (const auto& sender : senders) {
      if (sender->protocol == protocol) sender->send(bytes.data(), bytes.size());
    }
  }
  void send(OutputProtocol protocol, const std::string& text) const {
    send(protocol, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  void send_mavlink(const Pose& pose);

  std::vector<std::unique_ptr<Sender>> senders;
  std::uint8_t system = 1, sequence = 0, resets = 0;
  std::optional<std::uint32_t> submap;
  std::optional<Time> heartbeat;
};

PoseOutput::PoseOutput(const std::vector<Output>& outputs, std::uint8_t system)
    : state_(std::make_unique<State>()) {
  state_->system = system;
  for (const Output& output : outputs) state_->senders.push_back(std::make_unique<Sender>(output));
}

PoseOutput::~PoseOutput() = default;

void PoseOutput::State::send_mavlink(const Pose& pose) {
  if (!heartbeat || pose.time - *heartbeat >= kSecond) {
    heartbeat = pose.time;
    send(OutputProtocol::mavlink, mavlink_heartbeat(system, sequence++));
  }
  // An autopilot steers by it: dead reckoning by the same sensors would only repeat its own.
  if (!pose.metric || !pose.north || !pose.tracked) return;
  if (submap && *submap != pose.submap) ++resets;
  submap = pose.submap;
  const VisionPosition estimate{pose.time,         ned_from_survey(pose) * pose.position,
                                attitude_of(pose), pose.position_sigma,
                                pose.angle_sigma,  resets};
  send(OutputProtocol::mavlink, mavlink_vision_position(estimate, system, sequence++));
}

void PoseOutput::send(const Pose& pose) {
  State& s = *state_;
  s.send(OutputProtocol::json, pose_json(pose));
  if (pose.north) s.send(OutputProtocol::nmea, heading_line(pose));
  if (pose.geodetic) s.send(OutputProtocol::nmea, position_line(*pose.geodetic));
  s.send_mavlink(pose);
}

void PoseOutput::send(const Ground& ground) {
  json corners = json::array();
  for (const Eigen::Vector3d& corner : ground.footprint) corners.push_back(as_json(corner));
  const json object{{"type", "ground"},
                    {"image", ground.image},
                    {"submap", ground.submap},
                    {"normal", as_json(ground.normal)},
                    {"footprint", corners}};
  state_->send(OutputProtocol::json, object.dump());
}

bool PoseOutput::send(const Outline& coverage) {
  json polygons = json::array();
  for (const auto& polygon : coverage) {
    json corners = json::array();
    for (const Eigen::Vector2d& corner : polygon) corners.push_back({corner.x(), corner.y()});
    polygons.push_back(std::move(corners));
  }
  const std::string text = json{{"type", "coverage"}, {"outline", polygons}}.dump();
  if (text.size() > kMostBytes) return false;
  state_->send(OutputProtocol::json, text);
  return true;
}

}  // namespace nadir::sensors
