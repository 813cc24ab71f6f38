// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "text.hpp"

#include <array>
#include <charconv>
#include <limits>

#include "nadir/core/check.hpp"

namespace nadir::record {
namespace {

constexpr int kMostDecimals = 17;
constexpr std::size_t kLongest = std::numeric_limits<double>::max_exponent10 + kMostDecimals + 4;

bool is_zero(const std::string& text) { return text.find_first_not_of("-0.") == std::string::npos; }

}  // namespace

std::string fixed(double value, int decimals) {
  NADIR_CHECK(decimals <= kMostDecimals, decimals);
  std::array<char, kLongest> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, decimals);
  NADIR_CHECK(end.ec == std::errc(), value);
  std::string text(buffer.data(), end.ptr);
  return text.front() == '-' && is_zero(text) ? text.substr(1) : text;
}

std::string seconds_text(Time time) {
  constexpr std::uint64_t kPerSecond = 1'000'000'000;
  const auto bits = static_cast<std::uint64_t>(time);
  const std::uint64_t size = time < 0 ? 0 - bits : bits;
  std::string text(time < 0 ? 1 : 0, '-');
  text += padded(size / kPerSecond, 1);
  text += '.';
  return text += padded(size % kPerSecond, 9);
}

std::string padded(std::uint64_t value, std::size_t digits) {
  std::array<char, std::numeric_limits<std::uint64_t>::digits10 + 1> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end.ptr);
  return text.size() < digits ? std::string(digits - text.size(), '0') + text : text;
}

}  // namespace nadir::record
