// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Values to bytes and back, little-endian, without padding. A type is described once, by a function
// fields(archive, value) that names its members in order; it serves both directions.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace nadir::record {

using Bytes = std::vector<std::uint8_t>;

static_assert(std::endian::native == std::endian::little, "nadir runs on amd64 and arm64 only");

/// T or const T.
template <class Value, class T>
concept Is = std::same_as<std::remove_const_t<Value>, T>;

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class Encoder {
 public:
  static constexpr bool kReads = false;

  void operator()(const auto&... values) { (put(values), ...); }
  void raw(const void* bytes, std::size_t size) {
    const auto* from = static_cast<const std::uint8_t*>(bytes);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (Number<T>) {
      raw(&value, sizeof value);
    } else {
      fields(*this, value);
    }
  }

  Bytes bytes_;
};

/// Reads past the end give zeros and ok() turns false; lengths are checked before memory is taken.
class Decoder {
 public:
  static constexpr bool kReads = true;

  explicit Decoder(std::span<const std::uint8_t> bytes, bool pixels = true)
      : rest_(bytes), pixels_(pixels) {}
  void operator()(auto&... values) { (get(values), ...); }
  void raw(void* bytes, std::size_t size) {
    if (!holds(size)) return;
    std::copy_n(rest_.begin(), size, static_cast<std::uint8_t*>(bytes));
    rest_ = rest_.subspan(size);
  }
  /// Whether size more bytes are there; if not, the whole is not ok.
  bool holds(std::size_t size) { return ok_ = ok_ && size <= rest_.size(); }
  void fail() { ok_ = false; }
  bool ok() const { return ok_; }
  bool ended() const { return ok_ && rest_.empty(); }
  /// Whether images are wanted; without they are black, of their size.
  bool pixels() const { return pixels_; }

 private:
  template <class T>
  void get(T& value) {
    if constexpr (std::same_as<T, bool>) {
      std::uint8_t byte = 0;
      raw(&byte, 1);
      value = byte != 0;
    } else if constexpr (Number<T>) {
      raw(&value, sizeof value);
    } else {
      fields(*this, value);
    }
  }

  std::span<const std::uint8_t> rest_;
  bool pixels_;
  bool ok_ = true;
};

template <class Archive, class T>
void sized(Archive& archive, T& sequence) {
  auto size = static_cast<std::uint32_t>(sequence.size());
  archive(size);
  if constexpr (Archive::kReads) {
    if (!archive.holds(size)) return;  // no element takes less than a byte
    sequence.resize(size);
  }
}

template <class T>
constexpr bool is_vector = false;
template <class T>
constexpr bool is_vector<std::vector<T>> = true;
template <class T>
constexpr bool is_optional = false;
template <class T>
constexpr bool is_optional<std::optional<T>> = true;
template <class T>
constexpr bool is_array = false;
template <class T, std::size_t n>
constexpr bool is_array<std::array<T, n>> = true;
template <class T>
constexpr bool is_matrix = false;
template <class T, int rows, int columns>
constexpr bool is_matrix<Eigen::Matrix<T, rows, columns>> = true;

template <class Archive>
void fields(Archive& archive, Is<std::string> auto& text) {
  sized(archive, text);
  archive.raw(text.data(), text.size());
}

template <class Archive, class T>
requires is_vector<std::remove_const_t<T>>
void fields(Archive& archive, T& values) {
  sized(archive, values);
  for (auto& value : values) archive(value);
}

template <class Archive, class T>
requires is_array<std::remove_const_t<T>>
void fields(Archive& archive, T& values) {
  archive.raw(values.data(), sizeof(typename T::value_type) * values.size());
}

template <class Archive, class T>
requires is_optional<std::remove_const_t<T>>
void fields(Archive& archive, T& value) {
  bool present = value.has_value();
  archive(present);
  if constexpr (Archive::kReads) {
    if (present) value.emplace();
  }
  if (present) archive(*value);
}

/// Column by column.
template <class Archive, class T>
requires is_matrix<std::remove_const_t<T>>
void fields(Archive& archive, T& matrix) {
  archive.raw(matrix.data(), sizeof(typename T::Scalar) * static_cast<std::size_t>(matrix.size()));
}

}  // namespace nadir::record
