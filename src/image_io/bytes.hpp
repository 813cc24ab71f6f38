// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Bounds-checked reading of untrusted bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace nadir::image_io {

enum class ByteOrder { little, big };

/// None beyond the end; count is 1 to 4 bytes.
inline std::optional<std::uint32_t> read_uint(std::span<const std::uint8_t> data,
                                              std::size_t offset, std::size_t count,
                                              ByteOrder order) {
  if (offset > data.size() || data.size() - offset < count) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = order == ByteOrder::big ? i : count - 1 - i;
    value = value << 8 | data[offset + at];
  }
  return value;
}

}  // namespace nadir::image_io
