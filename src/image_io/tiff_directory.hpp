// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The directories of a TIFF structure (TIFF 6.0 section 2), which EXIF shares. Untrusted: every
// offset is checked and no chain of directories is followed.
#pragma once

#include <string_view>

#include "bytes.hpp"

namespace nadir::image_io {

class TiffDirectory {
 public:
  /// The first directory of a TIFF structure; none when data is not one.
  static std::optional<TiffDirectory> first(std::span<const std::uint8_t> data);
  /// The directory an entry of this one points to.
  std::optional<TiffDirectory> sub_directory(std::uint16_t tag) const;

  /// The first value of a BYTE, SHORT or LONG entry; none when absent or malformed.
  std::optional<std::uint32_t> number(std::uint16_t tag) const;
  /// An ASCII entry up to its first NUL; empty when absent or malformed.
  std::string_view text(std::uint16_t tag) const;

 private:
  struct Entry {
    std::uint16_t type = 0;
    std::uint32_t count = 0;
    std::size_t value = 0;  ///< offset of the four bytes of the value or of its offset
  };

  TiffDirectory(std::span<const std::uint8_t> data, ByteOrder order, std::size_t offset);
  std::optional<Entry> find(std::uint16_t tag) const;
  std::optional<std::uint32_t> read(std::size_t offset, std::size_t count) const {
    return read_uint(data_, offset, count, order_);
  }

  std::span<const std::uint8_t> data_;
  ByteOrder order_;
  std::size_t entries_ = 0;  ///< offset of the first entry
  std::uint32_t count_ = 0;
};

}  // namespace nadir::image_io
