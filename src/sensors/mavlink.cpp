// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/mavlink.hpp"

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <cmath>
#include <cstring>
#include <numbers>

#include "angle.hpp"

namespace nadir::sensors {
namespace {

constexpr std::uint8_t kVersion1 = 0xFE, kVersion2 = 0xFD;  // first bytes
constexpr std::size_t kHeader1 = 6, kHeader2 = 10, kChecksum = 2, kSignature = 13;
constexpr std::uint8_t kSigned = 1;             // incompat_flags
constexpr std::uint8_t kOnboardComputer = 191;  // MAV_COMP_ID_ONBOARD_COMPUTER

// crc_extra is a digest of the message's fields: both ends must know the same ones.
struct Message {
  std::uint32_t number;
  std::uint8_t crc_extra;
  std::uint8_t length;  ///< of the payload with its extensions
};
constexpr Message kHeartbeat{0, 50, 9}, kSystemTime{2, 137, 12}, kAttitude{30, 39, 28},
    kGlobalPositionInt{33, 104, 28}, kVisionPositionEstimate{102, 158, 117},
    kDistanceSensor{132, 85, 39}, kScaledPressure2{137, 195, 16}, kScaledPressure3{143, 131, 16};
constexpr std::array kUsed{kSystemTime,     kAttitude,        kGlobalPositionInt,
                           kDistanceSensor, kScaledPressure2, kScaledPressure3};

std::uint16_t checksum(std::span<const std::uint8_t> bytes, std::uint8_t crc_extra) {
  boost::crc_optimal<16, 0x1021, 0xFFFF, 0, true, true> crc;  // CRC-16/MCRF4XX
  crc.process_bytes(bytes.data(), bytes.size());
  crc.process_byte(crc_extra);
  return crc.checksum();
}

// Little-endian fields at their places in a payload, as every machine this runs on has them.
template <class T>
T field(const MavlinkPacket& packet, std::size_t at) {
  T value{};
  std::memcpy(&value, packet.payload.data() + at, sizeof value);
  return value;
}

class Payload {
 public:
  explicit Payload(const Message& message) : bytes_(message.length) {}
  template <class T>
  void set(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

std::vector<std::uint8_t> packed(const Message& message, const Payload& payload,
                                 std::uint8_t system, std::uint8_t sequence) {
  std::span<const std::uint8_t> body = payload.bytes();
  while (body.size() > 1 && body.back() == 0) body = body.first(body.size() - 1);
  const std::array<std::uint8_t, kHeader2> head{
      kVersion2,
      static_cast<std::uint8_t>(body.size()),
      0,
      0,
      sequence,
      system,
      kOnboardComputer,
      static_cast<std::uint8_t>(message.number & 0xFF),
      static_cast<std::uint8_t>(message.number >> 8 & 0xFF),
      static_cast<std::uint8_t>(message.number >> 16)};
  std::vector<std::uint8_t> packet(head.size() + body.size());
  std::ranges::copy(head, packet.begin());
  std::ranges::copy(body, packet.begin() + kHeader2);
  const std::uint16_t crc = checksum(std::span(packet).subspan(1), message.crc_extra);
  packet.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  packet.push_back(static_cast<std::uint8_t>(crc >> 8));
  return packet;
}

// A packet at the front of bytes, as far as its header tells.
struct Head {
  bool complete = false;  ///< the header is there, and all below is known
  std::uint32_t message = 0;
  std::size_t header = 0, payload = 0, whole = 0;
  std::uint8_t sequence = 0, system = 0, component = 0;
};

Head head_of(std::span<const std::uint8_t> bytes) {
  Head head;
  const bool second = bytes[0] == kVersion2;
  head.header = second ? kHeader2 : kHeader1;
  if (bytes.size() < head.header) return head;
  head.complete = true;
  head.payload = bytes[1];
  const std::size_t names = second ? 4 : 2;  // sequence, system, component, message
  head.sequence = bytes[names];
  head.system = bytes[names + 1];
  head.component = bytes[names + 2];
  head.message = bytes[names + 3];
  if (second) head.message |= std::uint32_t{bytes[8]} << 8 | std::uint32_t{bytes[9]} << 16;
  head.whole = head.header + head.payload + kChecksum;
  if (second && (bytes[2] & kSigned) != 0) head.whole += kSignature;
  return head;
}

std::optional<double> within(double value, double lowest, double highest) {
  return value >= lowest && value <= highest ? std::optional(value) : std::nullopt;
}

// Since the sender started; one that does not know says 0.
std::optional<Time> milliseconds(std::uint32_t ms) {
  return ms > 0 ? std::optional(Time{ms} * 1'000'000) : std::nullopt;
}

void attitude(const MavlinkPacket& packet, Reading& reading) {
  constexpr double kHalf = std::numbers::pi + 1e-6;
  reading.uptime = milliseconds(field<std::uint32_t>(packet, 0));
  reading.roll = within(field<float>(packet, 4), -kHalf, kHalf);
  reading.pitch = within(field<float>(packet, 8), -kHalf / 2, kHalf / 2);
  const auto yaw = within(field<float>(packet, 12), -2 * kHalf, 2 * kHalf);
  if (yaw) reading.heading = as_heading(*yaw);
  constexpr double kFastest = 100;  // rad/s
  reading.turn_rate = within(field<float>(packet, 24), -kFastest, kFastest);
}

// By convention barometers outside the hull; a thermometer among them says 0.
void pressure(const MavlinkPacket& packet, Reading& reading) {
  constexpr double kHectopascal = 100;
  reading.uptime = milliseconds(field<std::uint32_t>(packet, 0));
  reading.pressure =
      within(field<float>(packet, 4) * kHectopascal, 3e4, 1.3e8);  // Everest to the deepest trench
}

void distance(const MavlinkPacket& packet, Reading& reading) {
  constexpr std::uint8_t kDown = 25;  // MAV_SENSOR_ROTATION_PITCH_270
  constexpr std::uint8_t kInvalid = 1;
  const auto nearest = field<std::uint16_t>(packet, 4), farthest = field<std::uint16_t>(packet, 6),
             measured = field<std::uint16_t>(packet, 8);
  if (field<std::uint8_t>(packet, 12) != kDown || field<std::uint8_t>(packet, 38) == kInvalid)
    return;
  reading.uptime = milliseconds(field<std::uint32_t>(packet, 0));
  // Out of range is told as a value beyond its ends.
  if (measured > 0 && measured >= nearest && measured <= farthest)
    reading.altitude = measured / 100.0;
}

// ArduSub fills in depth and heading, and zeros without a position.
void global_position(const MavlinkPacket& packet, Reading& reading) {
  constexpr std::uint16_t kUnknown = 0xFFFF;
  reading.uptime = milliseconds(field<std::uint32_t>(packet, 0));
  const Position at{1e-7 * field<std::int32_t>(packet, 4), 1e-7 * field<std::int32_t>(packet, 8),
                    std::nullopt};
  const bool possible = std::abs(at.latitude_deg) <= 90 && std::abs(at.longitude_deg) <= 180;
  if (possible && (at.latitude_deg != 0 || at.longitude_deg != 0)) reading.position = at;
  reading.depth = within(-1e-3 * field<std::int32_t>(packet, 16), -100, 12000);
  const auto hdg = field<std::uint16_t>(packet, 26);
  if (hdg != kUnknown && hdg <= 36000) {
    reading.heading = as_heading(hdg / 100.0 * std::numbers::pi / 180);
  }
}

void system_time(const MavlinkPacket& packet, Reading& reading) {
  constexpr std::uint64_t kFirst = 1'577'836'800'000'000;  // 2020: unset clocks count from 0
  constexpr std::uint64_t kLast = 9'000'000'000'000'000;   // 2255: nanoseconds must fit
  const auto microseconds = field<std::uint64_t>(packet, 0);
  reading.uptime = milliseconds(field<std::uint32_t>(packet, 8));
  if (microseconds >= kFirst && microseconds <= kLast)
    reading.utc = static_cast<Time>(microseconds) * 1000;
}

}  // namespace

void MavlinkReader::feed(std::span<const std::uint8_t> bytes) {
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
}

std::optional<MavlinkPacket> MavlinkReader::next() {
  for (; begin_ < pending_.size(); ++begin_) {
    const auto bytes = std::span<const std::uint8_t>(pending_).subspan(begin_);
    if (bytes[0] != kVersion1 && bytes[0] != kVersion2) continue;
    const Head head = head_of(bytes);
    if (!head.complete) return std::nullopt;
    const auto used = std::ranges::find(kUsed, head.message, &Message::number);
    // What is no packet, or none of ours, is searched for the next first byte: its length is
    // nothing to go by.
    if (used == kUsed.end()) continue;
    if (bytes.size() < head.whole) return std::nullopt;
    const std::size_t end = head.header + head.payload;
    const auto sent = static_cast<std::uint16_t>(bytes[end] | bytes[end + 1] << 8);
    if (checksum(bytes.subspan(1, end - 1), used->crc_extra) != sent) {
      ++damaged_;
      continue;
    }
    MavlinkPacket packet{head.message, head.system, head.component, head.sequence, {}};
    packet.payload.assign(bytes.begin() + static_cast<std::ptrdiff_t>(head.header),
                          bytes.begin() + static_cast<std::ptrdiff_t>(end));
    packet.payload.resize(used->length);  // a newer sender may know more fields
    begin_ += head.whole;
    return packet;
  }
  return std::nullopt;
}

Reading decode_mavlink(const MavlinkPacket& packet) {
  Reading reading;
  const auto used = std::ranges::find(kUsed, packet.message, &Message::number);
  if (used == kUsed.end() || packet.payload.size() != used->length) return reading;
  reading.sender = packet.message << 16 | std::uint32_t{packet.system} << 8 | packet.component;
  switch (packet.message) {
    case kAttitude.number:
      attitude(packet, reading);
      break;
    case kScaledPressure2.number:
    case kScaledPressure3.number:
      pressure(packet, reading);
      break;
    case kDistanceSensor.number:
      distance(packet, reading);
      break;
    case kGlobalPositionInt.number:
      global_position(packet, reading);
      break;
    case kSystemTime.number:
      system_time(packet, reading);
      break;
    default:
      break;
  }
  return reading;
}

std::vector<std::uint8_t> mavlink_heartbeat(std::uint8_t system, std::uint8_t sequence) {
  constexpr std::uint8_t kTypeOnboardController = 18, kNoAutopilot = 8, kActive = 4, kVersion = 3;
  Payload payload(kHeartbeat);
  payload.set(4, kTypeOnboardController);
  payload.set(5, kNoAutopilot);
  payload.set(7, kActive);
  payload.set(8, kVersion);
  return packed(kHeartbeat, payload, system, sequence);
}

std::vector<std::uint8_t> mavlink_vision_position(const VisionPosition& estimate,
                                                  std::uint8_t system, std::uint8_t sequence) {
  Payload payload(kVisionPositionEstimate);
  payload.set(0, static_cast<std::uint64_t>(estimate.time / 1000));
  std::size_t at = 8;
  for (const double value :
       {estimate.position.x(), estimate.position.y(), estimate.position.z(), estimate.attitude.roll,
        estimate.attitude.pitch, estimate.attitude.yaw}) {
    payload.set(at, static_cast<float>(value));
    at += sizeof(float);
  }
  // The upper right triangle of the covariance, row by row; not a number first: unknown.
  constexpr std::array<std::size_t, 6> kDiagonal{0, 6, 11, 15, 18, 20};
  const bool known = estimate.position_sigma > 0 && estimate.angle_sigma > 0;
  if (!known) payload.set(at, std::nanf(""));
  for (std::size_t i = 0; known && i < kDiagonal.size(); ++i) {
    const double sigma = i < 3 ? estimate.position_sigma : estimate.angle_sigma;
    payload.set(at + sizeof(float) * kDiagonal[i], static_cast<float>(sigma * sigma));
  }
  payload.set(116, estimate.resets);
  return packed(kVisionPositionEstimate, payload, system, sequence);
}

}  // namespace nadir::sensors
