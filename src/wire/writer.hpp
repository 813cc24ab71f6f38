// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Writes a record's body from front to back.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "little_endian.hpp"
#include "nadir/core/check.hpp"
#include "nadir/wire/records.hpp"

namespace nadir::wire {

constexpr std::size_t kMaxText = 1024;  ///< bytes; a message a diver can read is far shorter

class Writer {
 public:
  explicit Writer(RecordType type) : record_(begin_record(static_cast<std::uint8_t>(type))) {}

  template <class T>
  Writer& number(T value) {
    append_little_endian(value, record_);
    return *this;
  }

  template <class T = double>
  Writer& finite(double value) {
    const T narrowed = static_cast<T>(value);
    NADIR_CHECK(std::isfinite(narrowed), static_cast<int>(record_[0]), value);
    return number(narrowed);
  }

  template <class Enum>
  Writer& choice(Enum value) {
    return number(static_cast<std::uint8_t>(value));
  }

  Writer& flag(bool value) { return number(static_cast<std::uint8_t>(value ? 1 : 0)); }

  Writer& blob(View bytes) {
    number(static_cast<std::uint32_t>(bytes.size()));
    record_.insert(record_.end(), bytes.begin(), bytes.end());
    return *this;
  }

  /// Over-long text is cut between two UTF-8 characters.
  Writer& text(std::string_view text) {
    std::size_t size = std::min(text.size(), kMaxText);
    while (size < text.size() && size > 0 && (static_cast<unsigned char>(text[size]) >> 6) == 2) {
      --size;
    }
    number(static_cast<std::uint16_t>(size));
    record_.insert(record_.end(), text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size));
    return *this;
  }

  Bytes finish() { return std::move(record_); }

 private:
  Bytes record_;
};

}  // namespace nadir::wire
