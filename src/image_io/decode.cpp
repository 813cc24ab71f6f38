// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/decode.hpp"

#include <opencv2/imgproc.hpp>

#include "codecs.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/reduce.hpp"

namespace nadir::image_io {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

}  // namespace

Decoded decode(std::span<const std::uint8_t> file, int width, int height, int divisor,
               Colour colour) {
  NADIR_CHECK(divisor == 1 || divisor == 2 || divisor == 4, divisor);
  const auto [header, fault] = read_header(file);
  if (!header) return {{}, fault};
  if (header->width != width || header->height != height) {
    return {{},
            "is " + size_text(header->width, header->height) + ", the calibration is for " +
                size_text(width, height)};
  }
  if (header->format == Format::jpeg) return decode_jpeg(file, *header, divisor, colour);
  Decoded decoded = header->format == Format::png ? decode_png(file, *header, colour)
                                                  : decode_tiff(file, *header, colour);
  decoded.image = reduce(decoded.image, divisor);
  return decoded;
}

Decoded decode_bgra(std::span<const std::uint8_t> file) {
  constexpr std::int64_t kMostPixels = 1 << 28;
  const auto [header, fault] = read_header(file);
  if (!header) return {{}, fault};
  if (header->format != Format::png || header->channels != 4 || header->bits != 8) {
    return {{}, "is not an 8-bit colour PNG with alpha"};
  }
  if (std::int64_t{header->width} * header->height > kMostPixels) return {{}, "is too large"};
  return decode_png_bgra(file, *header);
}

}  // namespace nadir::image_io
