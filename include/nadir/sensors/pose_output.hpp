// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Tells autopilots and chart programs where the vehicle is and what ground is covered.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nadir/core/time.hpp"
#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

enum class OutputProtocol { json, mavlink, nmea };

struct Output {
  OutputProtocol protocol{};
  std::string address;  ///< IP; of a network's broadcast address, too
  std::uint16_t port = 0;
};

/// PROTOCOL:udp:ADDRESS:PORT, protocol json, mavlink or nmea; several with spaces between. Throws
/// InputError naming the fault and the form.
std::vector<Output> parse_outputs(std::string_view text);

/// Of the vehicle when an image was taken, as it was known then: corrections by ground seen again
/// come into the map, not into this, which must not jump.
struct Pose {
  Time time = 0;  ///< of the images' clock
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  bool tracked = false;                                ///< else dead reckoned
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the camera, survey
  Eigen::Quaterniond survey_from_body = Eigen::Quaterniond::Identity();
  double position_sigma = 0, angle_sigma = 0;  ///< against the image before; 0: unknown
  bool metric = false;                         ///< survey units are metres
  bool north = false;                          ///< survey y is north and z is up
  double convergence = 0;  ///< from true north to survey y, clockwise seen from above, radians
  std::optional<Position> geodetic;
};

/// The ground that an image shows, in the survey frame.
struct Ground {
  std::uint64_t image = 0;
  std::uint32_t submap = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  std::vector<Eigen::Vector3d> footprint;  ///< corners in turn
};

using Outline = std::vector<std::vector<Eigen::Vector2d>>;  ///< polygons, survey x and y

/// Sends datagrams and never waits; what the network does not take is lost, as all of UDP may be.
/// json: an object each of "type" pose, ground or coverage. mavlink: VISION_POSITION_ESTIMATE of
/// metric poses that know north, and a heartbeat a second. nmea: HDT of those that know north, GGA
/// of those with a position.
class PoseOutput {
 public:
  /// system: the vehicle's number in MAVLink. Throws InputError when an address is none.
  PoseOutput(const std::vector<Output>& outputs, std::uint8_t system);
  ~PoseOutput();

  void send(const Pose& pose);
  void send(const Ground& ground);
  /// False when its text is longer than a datagram, 60 kB: nothing is sent, and a coarser outline
  /// may be.
  [[nodiscard]] bool send(const Outline& coverage);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::sensors
