// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/input.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "nadir/core/check.hpp"
#include "words.hpp"

namespace nadir::sensors {
namespace {

constexpr std::array<std::string_view, 3> kProtocols{"nmea", "mavlink", "iio"};
constexpr std::array<std::string_view, 4> kTransports{"serial", "udp", "tcp", "device"};
constexpr std::string_view kEveryAddress = "0.0.0.0";
constexpr std::uint32_t kHighestPort = 65535, kFastest = 4'000'000, kMostReadings = 100;

[[noreturn]] void refuse(std::string_view text, const std::string& fault) {
  throw InputError("sensor input \"" + std::string(text) + "\": " + fault +
                   "; give nmea or mavlink, then serial:DEVICE:BAUD, udp:PORT or tcp:HOST:PORT, or "
                   "iio:device:NAME:HZ, such as nmea:serial:/dev/ttyUSB0:4800, mavlink:udp:14550 "
                   "or iio:device:ms5837-30ba:20");
}

template <class Choice, std::size_t n>
std::optional<Choice> take(std::string_view& rest, const std::array<std::string_view, n>& names) {
  const std::size_t colon = rest.find(':');
  const std::string_view word = rest.substr(0, colon);
  for (std::size_t i = 0; i < n; ++i) {
    if (word != names[i]) continue;
    rest.remove_prefix(colon == rest.npos ? rest.size() : colon + 1);
    return static_cast<Choice>(i);
  }
  return std::nullopt;
}

std::optional<std::uint32_t> whole_number(std::string_view text, std::uint32_t most) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value == 0 || value > most) return std::nullopt;
  return value;
}

std::string without_brackets(std::string_view address) {
  const bool bracketed = address.starts_with('[') && address.ends_with(']');
  return std::string(bracketed ? address.substr(1, address.size() - 2) : address);
}

bool is_ip_address(std::string text) {
  text.resize(std::min(text.find('%'), text.size()));  // an interface's name
  in6_addr address{};                                  // of either kind
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 ||
         ::inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

}  // namespace

std::string Input::name() const {
  const bool six = transport != Transport::serial && protocol != Protocol::iio &&
                   address.find(':') != std::string::npos;
  std::string text = std::string(kProtocols[static_cast<std::size_t>(protocol)]) + ':' +
                     std::string(kTransports[static_cast<std::size_t>(transport)]) + ':';
  if (transport != Transport::udp || address != kEveryAddress)
    text += (six ? '[' + address + ']' : address) + ':';
  return text + std::to_string(rate);
}

Input parse_input(std::string_view text) {
  std::string_view rest = text;
  Input input;
  const auto protocol = take<Protocol>(rest, kProtocols);
  if (!protocol) refuse(text, "does not begin with nmea:, mavlink: or iio:");
  const auto transport = take<Transport>(rest, kTransports);
  const bool iio = *protocol == Protocol::iio;
  if (iio && transport != Transport::device) refuse(text, "of iio names no device:NAME:HZ");
  if (!transport || (!iio && transport == Transport::device))
    refuse(text, "names neither serial, udp nor tcp");
  input.protocol = *protocol;
  input.transport = *transport;
  // Device names may hold colons.
  const std::size_t colon = rest.rfind(':');
  const bool serial = input.transport == Transport::serial;
  const auto rate = whole_number(colon == rest.npos ? rest : rest.substr(colon + 1),
                                 serial ? kFastest : (iio ? kMostReadings : kHighestPort));
  if (!rate) {
    refuse(text, serial ? "ends in no baud rate"
                 : iio  ? "ends in no rate from 1 to 100 Hz"
                        : "ends in no port from 1 to 65535");
  }
  input.rate = *rate;
  if (colon != rest.npos) input.address = without_brackets(rest.substr(0, colon));
  if (input.address.empty() && input.transport == Transport::udp) input.address = kEveryAddress;
  if (input.transport == Transport::udp && !is_ip_address(input.address))
    refuse(text, "listens on no IP address of this machine");
  if (input.address.empty()) refuse(text, serial || iio ? "names no device" : "names no host");
  return input;
}

std::vector<Input> parse_inputs(std::string_view text) {
  std::vector<Input> inputs;
  for (const std::string_view word : words_of(text)) inputs.push_back(parse_input(word));
  return inputs;
}

}  // namespace nadir::sensors
