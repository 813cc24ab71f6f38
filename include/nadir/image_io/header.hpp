// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What an image file claims to be, read without trusting it: no decoder runs and nothing is
// allocated by a declared size.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace nadir::image_io {

enum class Format { jpeg, png, tiff };

/// A palette counts as 3 channels of 8 bits.
struct Header {
  Format format{};
  int width = 0, height = 0;  ///< px, as stored: an EXIF orientation is never applied
  int channels = 0;           ///< 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha
  int bits = 0;               ///< per channel, 1 to 16
};

/// A header, or the fault that makes the file unusable here: "truncated JPEG", "12-bit JPEG is not
/// supported", ...
struct Inspection {
  std::optional<Header> header;
  std::string fault;
};

/// Never throws, whatever the bytes. ITU-T T.81 annex B, PNG 1.2 section 11.2.2, TIFF 6.0
/// section 2.
Inspection read_header(std::span<const std::uint8_t> file);

}  // namespace nadir::image_io
