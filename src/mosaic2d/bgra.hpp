// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Pixels of four bytes as one value each, which compilers vectorise.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace nadir::mosaic2d {

constexpr std::ptrdiff_t kChannels = 4;
constexpr auto kAlpha = std::bit_cast<std::uint32_t>(std::array<std::uint8_t, 4>{0, 0, 0, 255});

inline std::uint32_t pixel_at(const std::uint8_t* bgra, int column) {
  std::uint32_t pixel;
  std::memcpy(&pixel, bgra + kChannels * column, sizeof pixel);
  return pixel;
}

}  // namespace nadir::mosaic2d
