// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Packets written by node-mavlink 2.3.0, so that both ends do not share a mistake.
#include "nadir/sensors/mavlink.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string_view>

namespace nadir::sensors {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFloat = 1e-6;

Bytes bytes_of(std::string_view hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(
        static_cast<std::uint8_t>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

// Sequence 7, system 1, component 1.
const Bytes kAttitude =
    bytes_of("fd1c00000701011e000040e20100cdcccc3dcdcc4cbe000040400ad7233c0ad7a33c8fc2f5bc9bcb");
const Bytes kAttitude1 =
    bytes_of("fe1c0701011e40e20100cdcccc3dcdcc4cbe000040400ad7233c0ad7a33c8fc2f5bc8cbc");
const Bytes kPressure2 = bytes_of("fd0e000007010189000041e201000050fd4400000000d204a23e");
const Bytes kPressure3 = bytes_of("fe100701018f42e201000000000000000000e605000062c7");
const Bytes kDistance = bytes_of(
    "fd27000007010184000043e201001e008813d700010019000000000000000000000000000000000000000000000000"
    "005a5396");
const Bytes kPosition =
    bytes_of("fd1c000007010121000044e20100071eb41995af2f03cccfffffcccfffff1e00d8ff000025431aaf");
const Bytes kTime = bytes_of("fd0b0000070101020000406e635fbd44060045e2016a5a");
const Bytes kHeartbeat = bytes_of("fd0900000701010000000000000012080004035560");

std::vector<MavlinkPacket> packets_of(const Bytes& bytes, std::size_t piece = 1000) {
  MavlinkReader reader;
  std::vector<MavlinkPacket> packets;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    reader.feed(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)));
    while (auto packet = reader.next()) packets.push_back(*std::move(packet));
  }
  return packets;
}

Reading read(const Bytes& bytes) {
  const auto packets = packets_of(bytes);
  EXPECT_EQ(packets.size(), 1u);
  return packets.empty() ? Reading() : decode_mavlink(packets.front());
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Mavlink, AttitudeOfBothVersions) {
  for (const Bytes& bytes : {kAttitude, kAttitude1}) {
    const Reading reading = read(bytes);
    EXPECT_NEAR(reading.roll.value(), 0.1, kFloat);
    EXPECT_NEAR(reading.pitch.value(), -0.2, kFloat);
    EXPECT_NEAR(reading.heading.value(), 3.0, kFloat);
    EXPECT_NEAR(reading.turn_rate.value(), -0.03, kFloat);
    EXPECT_EQ(reading.uptime, 123'456'000'000);
  }
  const MavlinkPacket packet = packets_of(kAttitude).front();
  EXPECT_EQ(packet.sequence, 7);
  EXPECT_EQ(packet.system, 1);
  EXPECT_EQ(packet.component, 1);
}

TEST(Mavlink, PressureOfTheSensorOutside) {
  EXPECT_NEAR(read(kPressure2).pressure.value(), 202650, 0.1);
  EXPECT_FALSE(read(kPressure3).pressure);  // a thermometer that calls itself a barometer
}

TEST(Mavlink, DistanceDownwardsIsAltitude) {
  EXPECT_DOUBLE_EQ(read(kDistance).altitude.value(), 2.15);
  MavlinkPacket packet = packets_of(kDistance).front();
  const auto altitude_with = [&](std::size_t at, std::uint8_t value) {
    MavlinkPacket changed = packet;
    changed.payload[at] = value;
    return decode_mavlink(changed).altitude;
  };
  EXPECT_FALSE(altitude_with(12, 0));  // looks ahead
  EXPECT_FALSE(altitude_with(38, 1));  // invalid
  EXPECT_TRUE(altitude_with(38, 0));   // does not say
  EXPECT_FALSE(altitude_with(8, 20));  // 20 cm, nearest is 30 cm
  EXPECT_FALSE(altitude_with(9, 20));  // 53 m, farthest is 50 m
}

TEST(Mavlink, PositionDepthAndHeading) {
  const Reading reading = read(kPosition);
  EXPECT_NEAR(reading.position->latitude_deg, 43.1234567, 1e-9);
  EXPECT_NEAR(reading.position->longitude_deg, 5.3456789, 1e-9);
  EXPECT_DOUBLE_EQ(reading.depth.value(), 12.34);
  EXPECT_NEAR(reading.heading.value(), 171.89 * kDegree, 1e-12);
  MavlinkPacket packet = packets_of(kPosition).front();
  std::fill_n(packet.payload.begin() + 4, 8, std::uint8_t{0});
  EXPECT_FALSE(decode_mavlink(packet).position);
  EXPECT_TRUE(decode_mavlink(packet).depth);
  packet.payload[26] = packet.payload[27] = 0xFF;
  EXPECT_FALSE(decode_mavlink(packet).heading);
}

TEST(Mavlink, SystemTime) {
  const Reading reading = read(kTime);
  EXPECT_EQ(reading.utc, 1'764'430'000'123'456'000);
  EXPECT_EQ(reading.uptime, 123'461'000'000);
  MavlinkPacket packet = packets_of(kTime).front();
  std::fill_n(packet.payload.begin(), 8, std::uint8_t{0});
  EXPECT_FALSE(decode_mavlink(packet).utc);
}

TEST(Mavlink, PacketsAreFoundHoweverTheBytesArriveAndWhateverLiesBetween) {
  Bytes signed_packet = kPressure2;
  signed_packet[2] = 1;  // its checksum is no longer right
  const Bytes stream = bytes_of("fe0501fd") + kHeartbeat + kAttitude + bytes_of("fdfffefe") +
                       signed_packet + kTime + kAttitude1 + kDistance + kPosition;
  for (const std::size_t piece : {1u, 2u, 13u, 1000u}) {
    std::vector<std::uint32_t> messages;
    for (const MavlinkPacket& packet : packets_of(stream, piece))
      messages.push_back(packet.message);
    EXPECT_THAT(messages, testing::ElementsAre(30, 2, 30, 132, 33)) << piece;
  }
}

TEST(Mavlink, ADamagedPacketIsCountedAndNeverRead) {
  for (std::size_t at = 1; at < kAttitude1.size(); ++at) {
    Bytes damaged = kAttitude1;
    damaged[at] ^= 0x10;
    // Longer than itself, by the damage, it must not swallow what follows for ever.
    const Bytes rest(300, 0);
    const auto packets = packets_of(damaged + rest + kTime);
    ASSERT_EQ(packets.size(), 1u) << at;
    EXPECT_EQ(packets.front().message, 2u) << at;
  }
  MavlinkReader reader;
  Bytes damaged = kAttitude;
  damaged[20] ^= 1;
  reader.feed(damaged);
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damaged(), 1u);
}

TEST(Mavlink, RandomBytesAndMutatedPacketsGiveOnlyPossibleValues) {
  const std::vector<Bytes> packets{kAttitude, kPressure2, kPressure3, kDistance, kPosition, kTime};
  std::mt19937 random(1);
  const auto possible = [](const std::optional<double>& value, double lowest, double highest) {
    return !value || (*value >= lowest && *value <= highest);
  };
  constexpr double kPi = std::numbers::pi;
  for (int i = 0; i < 300'000; ++i) {
    MavlinkPacket packet = packets_of(packets[random() % packets.size()]).front();
    for (int changes = 0; changes < 4; ++changes)
      packet.payload[random() % packet.payload.size()] = static_cast<std::uint8_t>(random());
    const Reading r = decode_mavlink(packet);
    ASSERT_TRUE(possible(r.roll, -3.2, 3.2) && possible(r.pitch, -1.6, 1.6));
    ASSERT_TRUE(possible(r.heading, 0, 2 * kPi) && r.heading != 2 * kPi);
    ASSERT_TRUE(possible(r.turn_rate, -100, 100) && possible(r.depth, -100, 12000));
    ASSERT_TRUE(possible(r.pressure, 3e4, 1.3e8) && possible(r.altitude, 0.01, 655.35));
    if (r.position) {
      ASSERT_TRUE(possible(r.position->latitude_deg, -90, 90));
      ASSERT_TRUE(possible(r.position->longitude_deg, -180, 180));
    }
  }
}

TEST(Mavlink, HeartbeatHasTheBytesOfTheReference) {
  Bytes expected = bytes_of("fd090000070101000000");
  const Bytes sent = mavlink_heartbeat(1, 7);
  // The reference was written as component 1; ours is 191, so the checksum differs.
  expected[6] = 191;
  ASSERT_EQ(sent.size(), kHeartbeat.size());
  EXPECT_THAT(Bytes(sent.begin(), sent.begin() + 10), testing::ElementsAreArray(expected));
  EXPECT_THAT(Bytes(sent.begin() + 10, sent.end() - 2),
              testing::ElementsAreArray(kHeartbeat.begin() + 10, kHeartbeat.end() - 2));
}

TEST(Mavlink, VisionPositionHasTheBytesOfTheReference) {
  const Bytes reference = bytes_of(
      "fd750000070101660000404b4c00000000000000c03f000020c000005040cdcccc3dcdcc4cbe0000404017b7d139"
      "000000000000000000000000000000000000000017b7d1390000000000000000000000000000000017b7d1390000"
      "000000000000000000000ad7233c00000000000000000ad7233c000000000ad7233c02082b");
  VisionPosition estimate;
  estimate.time = 5'000'000'000;
  estimate.position = {1.5, -2.5, 3.25};
  estimate.attitude = {0.1, -0.2, 3.0};
  estimate.position_sigma = 0.02;
  estimate.angle_sigma = 0.1;
  estimate.resets = 2;
  const Bytes sent = mavlink_vision_position(estimate, 1, 7);
  ASSERT_EQ(sent.size(), reference.size());
  EXPECT_THAT(Bytes(sent.begin() + 10, sent.end() - 2),
              testing::ElementsAreArray(reference.begin() + 10, reference.end() - 2));
  estimate.angle_sigma = 0;
  const Bytes unknown = mavlink_vision_position(estimate, 1, 7);
  float first = 0;
  std::memcpy(&first, unknown.data() + 10 + 32, sizeof first);
  EXPECT_TRUE(std::isnan(first));
}

}  // namespace
}  // namespace nadir::sensors
