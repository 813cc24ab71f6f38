// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A PNG piece by piece in bounded memory, kept from image to image: three rows or 128 KB of pixels,
// 128 KB of file and 0.3 MB of the compressor.
#pragma once

#include <isa-l/igzip_lib.h>

#include <array>
#include <memory>

#include "nadir/image_io/encode.hpp"
#include "png_rows.hpp"

namespace nadir::image_io {

class PngStream {
 public:
  /// Begins a file, whatever became of the one before. The sink is used until finish() returns.
  void start(int width, int height, int type, PngEffort effort, PngWriter::Sink sink);
  /// The next rows from the top, of the width and type given; false once the sink failed.
  [[nodiscard]] bool rows(const cv::Mat& rows);
  /// False when the sink failed at any time.
  [[nodiscard]] bool finish();

 private:
  void deflate(std::span<const std::uint8_t> filtered, std::uint16_t flush, bool last = false);
  void send_pixels();
  void send(std::span<const std::uint8_t> piece);

  static constexpr std::size_t kChunk = 65536;
  struct Compressor {
    isal_zstream stream;
    std::array<std::uint8_t, ISAL_DEF_LVL2_MEDIUM> level_buffer;
    std::array<std::uint8_t, kChunk> out;
  };
  std::unique_ptr<Compressor> compressor_;
  PngRows rows_;
  int rows_at_once_ = 0;
  std::vector<std::uint8_t> chunk_;
  PngWriter::Sink sink_;
  bool failed_ = false;
};

}  // namespace nadir::image_io
