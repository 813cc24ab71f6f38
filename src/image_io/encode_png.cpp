// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <libdeflate.h>

#include <opencv2/imgproc.hpp>
#include <string_view>

#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "png_format.hpp"

namespace nadir::image_io {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append_uint32(Bytes& file, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) file.push_back(static_cast<std::uint8_t>(value >> shift));
}

// PNG 1.2, 5.3: length, type, data, CRC of type and data.
void append_chunk(Bytes& file, std::string_view type, std::span<const std::uint8_t> data) {
  append_uint32(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t start = file.size();
  file.insert(file.end(), type.begin(), type.end());
  file.insert(file.end(), data.begin(), data.end());
  append_uint32(file, libdeflate_crc32(0, file.data() + start, file.size() - start));
}

Bytes header(const cv::Mat& image) {
  Bytes data;
  append_uint32(data, static_cast<std::uint32_t>(image.cols));
  append_uint32(data, static_cast<std::uint32_t>(image.rows));
  data.push_back(static_cast<std::uint8_t>(8 * image.elemSize1()));
  data.push_back(static_cast<std::uint8_t>(png_colour_type(image.channels())));
  data.insert(data.end(), {0, 0, 0});  // deflate, the five filters, not interlaced
  return data;
}

// PNG 1.2, 4.2.3.1: a registered keyword, a zero, the text.
Bytes text(std::string_view description) {
  constexpr std::string_view kKeyword = "Description";
  Bytes data(kKeyword.begin(), kKeyword.end());
  data.push_back(0);
  data.insert(data.end(), description.begin(), description.end());
  return data;
}

// Channels and bytes in PNG's order.
cv::Mat in_file_order(const cv::Mat& image) {
  if (image.type() == CV_8UC1) return image;
  cv::Mat ordered;
  if (image.type() == CV_8UC3) cv::cvtColor(image, ordered, cv::COLOR_BGR2RGB);
  if (image.type() == CV_8UC4) cv::cvtColor(image, ordered, cv::COLOR_BGRA2RGBA);
  if (image.type() == CV_16UC1) {
    ordered = cv::Mat(image.rows, image.cols, CV_8UC2);
    for (int row = 0; row < image.rows; ++row) {
      const auto* from = image.ptr<std::uint16_t>(row);
      for (int column = 0; column < image.cols; ++column) {
        ordered.at<cv::Vec2b>(row, column) = {static_cast<std::uint8_t>(from[column] >> 8),
                                              static_cast<std::uint8_t>(from[column])};
      }
    }
  }
  return ordered;
}

// Each row as the difference to the one above (PNG 1.2, 9.2), after a byte that says so.
Bytes filtered(const cv::Mat& ordered) {
  constexpr std::uint8_t kUp = 2;
  const std::size_t row_size = static_cast<std::size_t>(ordered.cols) * ordered.elemSize();
  Bytes rows(static_cast<std::size_t>(ordered.rows) * (row_size + 1));
  const Bytes zeros(row_size, 0);
  const std::uint8_t* above = zeros.data();
  std::uint8_t* to = rows.data();
  for (int row = 0; row < ordered.rows; ++row) {
    const std::uint8_t* from = ordered.ptr(row);
    *to++ = kUp;
    for (std::size_t i = 0; i < row_size; ++i)
      to[i] = static_cast<std::uint8_t>(from[i] - above[i]);
    to += row_size;
    above = from;
  }
  return rows;
}

Bytes compressed(const Bytes& data, PngEffort effort) {
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(compression_level(effort)), libdeflate_free_compressor);
  Bytes result(libdeflate_zlib_compress_bound(compressor.get(), data.size()));
  const std::size_t size = libdeflate_zlib_compress(compressor.get(), data.data(), data.size(),
                                                    result.data(), result.size());
  NADIR_CHECK(size > 0, data.size());
  result.resize(size);
  return result;
}

}  // namespace

std::vector<std::uint8_t> encode_png(const cv::Mat& image, PngEffort effort,
                                     std::string_view description) {
  const int type = image.type();
  NADIR_CHECK(type == CV_8UC1 || type == CV_8UC3 || type == CV_8UC4 || type == CV_16UC1, type);
  constexpr std::size_t kLargestChunk = 0x7fffffff;
  NADIR_CHECK(!image.empty() && image.total() * image.elemSize() < kLargestChunk / 2, image.cols,
              image.rows);
  const Bytes pixels = compressed(filtered(in_file_order(image)), effort);
  Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  file.reserve(pixels.size() + 64);
  append_chunk(file, "IHDR", header(image));
  if (!description.empty()) append_chunk(file, "tEXt", text(description));
  append_chunk(file, "IDAT", pixels);
  append_chunk(file, "IEND", {});
  return file;
}

}  // namespace nadir::image_io
