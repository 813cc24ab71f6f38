// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Reads a record's body from front to back; after the first fault everything reads as zero.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "little_endian.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::wire {

class Reader {
 public:
  Reader(View record, RecordType type)
      : rest_(record),
        good_(record.size() >= kHeaderSize && record[0] == static_cast<std::uint8_t>(type) &&
              record[1] == kVersion) {
    if (good_) {
      rest_ = record.subspan(kHeaderSize);
    }
  }

  template <class T>
  T number() {
    const View bytes = take(sizeof(T));
    return bytes.empty() ? T{} : load_little_endian<T>(bytes.data());
  }

  template <class T = double>
  double finite() {
    const double value = static_cast<double>(number<T>());
    require(std::isfinite(value));
    return good_ ? value : 0;
  }

  double positive() {
    const double value = finite();
    require(value > 0);
    return value;
  }

  template <class Enum>
  Enum choice(Enum last) {
    const auto value = number<std::uint8_t>();
    require(value <= static_cast<std::uint8_t>(last));
    return good_ ? static_cast<Enum>(value) : Enum{};
  }

  bool flag() {
    const auto value = number<std::uint8_t>();
    require(value <= 1);
    return value == 1;
  }

  /// u32 length, then as many bytes.
  Bytes blob() {
    const View bytes = take(number<std::uint32_t>());
    return {bytes.begin(), bytes.end()};
  }

  /// u16 length, then UTF-8.
  std::string text() {
    const View bytes = take(number<std::uint16_t>());
    return {bytes.begin(), bytes.end()};
  }

  View take(std::size_t size) {
    require(size <= rest_.size());
    if (!good_) {
      return {};
    }
    const View taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  void require(bool condition) { good_ = good_ && condition; }

  /// The value, if nothing was at fault and nothing is left.
  template <class T>
  std::optional<T> finish(T value) const {
    return good_ && rest_.empty() ? std::optional<T>(std::move(value)) : std::nullopt;
  }

  bool good() const { return good_; }

 private:
  View rest_;
  bool good_;
};

}  // namespace nadir::wire
