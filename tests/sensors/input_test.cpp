// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/input.hpp"

#include <gtest/gtest.h>

#include "nadir/core/check.hpp"

namespace nadir::sensors {
namespace {

TEST(Input, IsReadAndNamedTheSameWay) {
  for (const char* text :
       {"nmea:serial:/dev/ttyUSB0:4800", "mavlink:udp:14550", "nmea:udp:127.0.0.1:10110",
        "nmea:tcp:gps.local:2000", "mavlink:tcp:[fe80::1]:5760", "nmea:udp:[::]:10110",
        "iio:device:ms5837-30ba:20",
        "mavlink:serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0:115200"}) {
    EXPECT_EQ(parse_input(text).name(), text);
  }
  const Input serial = parse_input("mavlink:serial:/dev/serial/by-path/a:1:115200");
  EXPECT_EQ(serial.protocol, Protocol::mavlink);
  EXPECT_EQ(serial.transport, Transport::serial);
  EXPECT_EQ(serial.address, "/dev/serial/by-path/a:1");
  EXPECT_EQ(serial.rate, 115200u);
  EXPECT_EQ(parse_input("nmea:udp:10110").address, "0.0.0.0");
  EXPECT_EQ(parse_input("mavlink:tcp:[fe80::1]:5760").address, "fe80::1");
}

TEST(Input, ListsAreSplitAtSpaces) {
  const auto inputs = parse_inputs("  nmea:udp:1 \t mavlink:udp:2 ");
  ASSERT_EQ(inputs.size(), 2u);
  EXPECT_EQ(inputs[1].rate, 2u);
  EXPECT_TRUE(parse_inputs("").empty());
  EXPECT_TRUE(parse_inputs("  ").empty());
}

TEST(Input, MalformedIsRefusedWithItsFaultAndTheForm) {
  for (const auto& [text, fault] : {std::pair{"gps:udp:1", "mavlink: or iio:"},
                                    {"nmea:usb:1", "serial, udp nor tcp"},
                                    {"nmea:udp:", "no port"},
                                    {"nmea:udp:0", "no port"},
                                    {"nmea:udp:foo:9300", "no IP address"},
                                    {"nmea:udp:65536", "no port"},
                                    {"nmea:udp:1x", "no port"},
                                    {"nmea:tcp:2000", "no host"},
                                    {"nmea:serial:4800", "no device"},
                                    {"nmea:serial:/dev/ttyS0", "no baud rate"},
                                    {"nmea:serial:/dev/ttyS0:0", "no baud rate"},
                                    {"nmea", "serial, udp nor tcp"},
                                    {"nmea:device:x:1", "serial, udp nor tcp"},
                                    {"iio:udp:1", "device:NAME:HZ"},
                                    {"iio:device:ms5837:0", "no rate"},
                                    {"iio:device:ms5837:101", "no rate"},
                                    {"iio:device:20", "no device"},
                                    {"", "mavlink: or iio:"}}) {
    try {
      (void)parse_input(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(fault), std::string::npos) << message;
      EXPECT_NE(message.find("such as nmea:serial:/dev/ttyUSB0:4800"), std::string::npos);
      EXPECT_NE(message.find("or iio:device:NAME:HZ"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace nadir::sensors
