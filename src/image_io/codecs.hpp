// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One decoder per format, called after the header was checked against the calibrated size.
#pragma once

#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/header.hpp"

namespace nadir::image_io {

/// Already reduced by the divisor.
Decoded decode_jpeg(std::span<const std::uint8_t> file, const Header& header, int divisor,
                    Colour colour);
/// At full size.
Decoded decode_png(std::span<const std::uint8_t> file, const Header& header, Colour colour);
Decoded decode_png_bgra(std::span<const std::uint8_t> file, const Header& header);
Decoded decode_tiff(std::span<const std::uint8_t> file, const Header& header, Colour colour);

}  // namespace nadir::image_io
