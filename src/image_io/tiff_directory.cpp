// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "tiff_directory.hpp"

namespace nadir::image_io {
namespace {

constexpr std::size_t kEntrySize = 12;
constexpr std::uint16_t kByte = 1, kAscii = 2, kShort = 3, kLong = 4;

std::size_t size_of(std::uint16_t type) {
  if (type == kShort) return 2;
  return type == kLong ? 4 : 1;
}

}  // namespace

TiffDirectory::TiffDirectory(std::span<const std::uint8_t> data, ByteOrder order,
                             std::size_t offset)
    : data_(data), order_(order), entries_(offset + 2), count_(read(offset, 2).value_or(0)) {}

std::optional<TiffDirectory> TiffDirectory::first(std::span<const std::uint8_t> data) {
  const auto mark = read_uint(data, 0, 2, ByteOrder::big);
  if (mark != 0x4949 && mark != 0x4d4d) return std::nullopt;
  const ByteOrder order = mark == 0x4949 ? ByteOrder::little : ByteOrder::big;
  const auto offset = read_uint(data, 4, 4, order);
  if (read_uint(data, 2, 2, order) != 42 || !offset) return std::nullopt;
  return TiffDirectory(data, order, *offset);
}

std::optional<TiffDirectory> TiffDirectory::sub_directory(std::uint16_t tag) const {
  const auto offset = number(tag);
  if (!offset) return std::nullopt;
  return TiffDirectory(data_, order_, *offset);
}

std::optional<TiffDirectory::Entry> TiffDirectory::find(std::uint16_t tag) const {
  for (std::uint32_t i = 0; i < count_; ++i) {
    const std::size_t at = entries_ + i * kEntrySize;
    const auto found = read(at, 2), type = read(at + 2, 2), count = read(at + 4, 4);
    if (!count) return std::nullopt;
    if (found == tag) return Entry{static_cast<std::uint16_t>(*type), *count, at + 8};
  }
  return std::nullopt;
}

std::optional<std::uint32_t> TiffDirectory::number(std::uint16_t tag) const {
  const auto entry = find(tag);
  if (!entry || entry->count == 0) return std::nullopt;
  if (entry->type != kByte && entry->type != kShort && entry->type != kLong) return std::nullopt;
  const std::size_t size = size_of(entry->type);
  if (entry->count <= 4 / size) return read(entry->value, size);
  const auto offset = read(entry->value, 4);
  return offset ? read(*offset, size) : std::nullopt;
}

std::string_view TiffDirectory::text(std::uint16_t tag) const {
  const auto entry = find(tag);
  if (!entry || entry->type != kAscii) return {};
  std::size_t at = entry->value;
  if (entry->count > 4) {
    const auto offset = read(entry->value, 4);
    if (!offset) return {};
    at = *offset;
  }
  if (at > data_.size() || data_.size() - at < entry->count) return {};
  const std::string_view all(reinterpret_cast<const char*>(data_.data()) + at, entry->count);
  return all.substr(0, all.find('\0'));
}

}  // namespace nadir::image_io
