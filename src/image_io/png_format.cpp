// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "png_format.hpp"

#include <isa-l/crc.h>

#include <opencv2/core/mat.hpp>

namespace nadir::image_io {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append_uint32(Bytes& file, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) file.push_back(static_cast<std::uint8_t>(value >> shift));
}

// PNG 11.2.2.
std::uint8_t colour_type(int channels) {
  constexpr std::uint8_t kGrey = 0, kRgb = 2, kRgba = 6;
  if (channels == 1) return kGrey;
  return channels == 3 ? kRgb : kRgba;
}

Bytes header(int width, int height, int type) {
  Bytes data;
  append_uint32(data, static_cast<std::uint32_t>(width));
  append_uint32(data, static_cast<std::uint32_t>(height));
  data.push_back(static_cast<std::uint8_t>(8 * CV_ELEM_SIZE1(type)));
  data.push_back(colour_type(CV_MAT_CN(type)));
  data.insert(data.end(), {0, 0, 0});  // deflate, the five filters, not interlaced
  return data;
}

}  // namespace

void append_chunk(Bytes& file, std::string_view type, std::span<const std::uint8_t> data) {
  append_uint32(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t start = file.size();
  file.insert(file.end(), type.begin(), type.end());
  file.insert(file.end(), data.begin(), data.end());
  append_uint32(file, crc32_gzip_refl(0, file.data() + start, file.size() - start));
}

Bytes png_head(int width, int height, int type) {
  Bytes head{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  append_chunk(head, "IHDR", header(width, height, type));
  return head;
}

}  // namespace nadir::image_io
