// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The parts of a PNG that are not pixels. PNG: W3C, 2nd edition.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace nadir::image_io {

/// Length, type, data, CRC of type and data (PNG 5.3).
void append_chunk(std::vector<std::uint8_t>& file, std::string_view type,
                  std::span<const std::uint8_t> data);

/// What comes before the pixels: signature and IHDR. type: CV_8UC1, CV_8UC3, CV_8UC4 or CV_16UC1.
std::vector<std::uint8_t> png_head(int width, int height, int type);

}  // namespace nadir::image_io
