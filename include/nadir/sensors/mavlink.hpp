// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// MAVLink 1 and 2 packets of autopilots (mavlink.io, common.xml): ArduSub on a BlueROV2 and its
// like.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "nadir/core/frame.hpp"
#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

struct MavlinkPacket {
  std::uint32_t message = 0;  ///< its number in common.xml
  std::uint8_t system = 0, component = 0, sequence = 0;
  std::vector<std::uint8_t> payload;  ///< at full length: the zeros that MAVLink 2 cuts are back
};

/// The packets of a stream of bytes or of datagrams. Messages not used here, damaged packets and
/// other bytes are passed over.
class MavlinkReader {
 public:
  void feed(std::span<const std::uint8_t> bytes);
  /// The next whole one; none when more bytes are needed.
  std::optional<MavlinkPacket> next();
  /// Of used messages whose checksum was wrong.
  std::uint64_t damaged() const { return damaged_; }

 private:
  std::vector<std::uint8_t> pending_;
  std::size_t begin_ = 0;  ///< of what was not yet looked at
  std::uint64_t damaged_ = 0;
};

/// ATTITUDE, SCALED_PRESSURE2 and 3, DISTANCE_SENSOR (looking down), GLOBAL_POSITION_INT,
/// SYSTEM_TIME; empty for others.
Reading decode_mavlink(const MavlinkPacket& packet);

/// What a companion computer sends of itself once a second, as system's onboard computer.
std::vector<std::uint8_t> mavlink_heartbeat(std::uint8_t system, std::uint8_t sequence);

struct VisionPosition {
  Time time = 0;                                       ///< of the sender's clock
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the body, north-east-down, metres
  Attitude attitude;
  double position_sigma = 0;  ///< metres; 0 when unknown
  double angle_sigma = 0;     ///< radians
  std::uint8_t resets = 0;    ///< counts up with each new sub-map and each correction
};

/// VISION_POSITION_ESTIMATE, MAVLink 2.
std::vector<std::uint8_t> mavlink_vision_position(const VisionPosition& estimate,
                                                  std::uint8_t system, std::uint8_t sequence);

}  // namespace nadir::sensors
