// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where a sensor's sentences or packets come from.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace nadir::sensors {

enum class Protocol { nmea, mavlink, iio };
enum class Transport { serial, udp, tcp, device };

struct Input {
  Protocol protocol{};
  Transport transport{};
  /// Device file; name or number of the host; udp: of the own address; IIO: the device's name.
  std::string address;
  std::uint32_t rate =
      0;  ///< of a serial line, baud; of an IIO device, readings a second; the port

  std::string name() const;  ///< as parse_input takes it
};

/// PROTOCOL:serial:DEVICE:BAUD, PROTOCOL:udp:[ADDRESS:]PORT (listens, on every address unless one
/// is given) or PROTOCOL:tcp:HOST:PORT (connects); protocol: nmea or mavlink. An IPv6 address
/// stands in brackets. iio:device:NAME:HZ reads a sensor on the board, see IioDevice. Throws
/// InputError naming the fault and the form.
Input parse_input(std::string_view text);

/// Several, with spaces between; none for an empty text.
std::vector<Input> parse_inputs(std::string_view text);

}  // namespace nadir::sensors
