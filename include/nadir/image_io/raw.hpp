// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images as cameras give them without compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "nadir/image_io/decode.hpp"

namespace nadir::image_io {

/// Layouts of pixels, by the names and definitions of V4L2 (linux/videodev2.h).
enum class RawFormat : std::uint8_t {
  grey,      ///< 8 bits
  yuyv,      ///< two pixels in Y U Y V, of BT.601, 16 to 235
  nv12,      ///< all Y, then U V of two by two pixels, likewise
  bgr24,     ///< three bytes a pixel: blue, green, red
  rgb24,     ///< red, green, blue
  bayer8,    ///< a byte a pixel
  bayer10,   ///< two bytes a pixel, little-endian, ten bits of them used
  bayer10p,  ///< MIPI's: four pixels in five bytes, the last with two bits of each
};
std::string_view to_string(RawFormat format);

/// The colours of the first two pixels of the first row, and of the second.
enum class BayerOrder : std::uint8_t { rggb, grbg, gbrg, bggr };

struct RawImage {
  RawFormat format{};
  BayerOrder order{};  ///< of a Bayer pattern
  int width = 0, height = 0;
  std::size_t stride = 0;  ///< bytes from row to row, of NV12's U V, too
  std::span<const std::uint8_t> bytes;
};

/// As decode(): divisor 1, 2 or 4 per side, pixel areas averaged. Ten bits are reduced to eight,
/// grey is that of the colours. A fault when the bytes are too few for the size, or the size is odd
/// where the layout has pairs. Never throws on bad images.
Decoded decode_raw(const RawImage& raw, int divisor, Colour colour);

}  // namespace nadir::image_io
