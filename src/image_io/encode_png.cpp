// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <libdeflate.h>

#include <algorithm>
#include <memory>

#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "png_format.hpp"
#include "png_rows.hpp"
#include "png_stream.hpp"

namespace nadir::image_io {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes fast(const cv::Mat& image) {
  thread_local PngStream stream;  // both keep their memory for the thread's next image
  thread_local Bytes file;
  file.clear();
  stream.start(image.cols, image.rows, image.type(), PngEffort::fast,
               [](std::span<const std::uint8_t> piece) {
                 file.insert(file.end(), piece.begin(), piece.end());
                 return true;
               });
  NADIR_CHECK(stream.rows(image));
  NADIR_CHECK(stream.finish());
  return file;  // a copy of the right size
}

Bytes filtered(const cv::Mat& image) {
  constexpr int kRowsAtOnce = 16;
  PngRows rows;
  rows.start(image.cols, image.type(), kRowsAtOnce);
  Bytes result;
  result.reserve(static_cast<std::size_t>(image.rows) + image.total() * image.elemSize());
  for (int row = 0; row < image.rows; row += kRowsAtOnce) {
    const auto next = rows.filtered(image.rowRange(row, std::min(row + kRowsAtOnce, image.rows)));
    result.insert(result.end(), next.begin(), next.end());
  }
  return result;
}

Bytes compressed(const Bytes& data) {
  constexpr int kLevel = 3;  // png_stream.cpp has the figures
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  Bytes result(libdeflate_zlib_compress_bound(compressor.get(), data.size()));
  const std::size_t size = libdeflate_zlib_compress(compressor.get(), data.data(), data.size(),
                                                    result.data(), result.size());
  NADIR_CHECK(size > 0, data.size());
  result.resize(size);
  return result;
}

Bytes small(const cv::Mat& image) {
  const Bytes pixels = compressed(filtered(image));
  Bytes file = png_head(image.cols, image.rows, image.type());
  file.reserve(file.size() + pixels.size() + 64);
  append_chunk(file, "IDAT", pixels);
  append_chunk(file, "IEND", {});
  return file;
}

}  // namespace

std::vector<std::uint8_t> encode_png(const cv::Mat& image, PngEffort effort) {
  const int type = image.type();
  NADIR_CHECK(type == CV_8UC1 || type == CV_8UC3 || type == CV_8UC4 || type == CV_16UC1, type);
  constexpr std::size_t kLargestChunk = 0x7fffffff;
  NADIR_CHECK(!image.empty() && image.total() * image.elemSize() < kLargestChunk / 2, image.cols,
              image.rows);
  return effort == PngEffort::fast ? fast(image) : small(image);
}

}  // namespace nadir::image_io
