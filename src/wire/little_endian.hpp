// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Numbers as little-endian bytes, whatever the machine.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace nadir::wire {

static_assert(std::endian::native == std::endian::little, "nadir runs on amd64 and arm64 only");

template <class T>
void store_little_endian(T value, std::uint8_t* to) {
  std::memcpy(to, &value, sizeof value);
}

template <class T>
T load_little_endian(const std::uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class T>
void append_little_endian(T value, std::vector<std::uint8_t>& to) {
  to.resize(to.size() + sizeof value);
  store_little_endian(value, to.data() + to.size() - sizeof value);
}

}  // namespace nadir::wire
