// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// JPEG, PNG and TIFF files to images.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace nadir::image_io {

enum class Colour { grey, bgr };

struct Decoded {
  cv::Mat image;      ///< CV_8UC1 or CV_8UC3 BGR; empty when there is a fault
  std::string fault;  ///< in words that complete "left/0001.jpg: ..."
};

/// Refuses before decoding unless the declared size equals width x height. divisor is 1, 2 or 4 per
/// side: pixel areas are averaged and the result is ceil(size / divisor), as CameraModel::reduced
/// has it. 16 bits are reduced to 8, alpha is ignored, an EXIF orientation is never applied. A file
/// that is damaged anywhere gives a fault, never part of an image. Never throws on bad files.
Decoded decode(std::span<const std::uint8_t> file, int width, int height, int divisor,
               Colour colour);

/// An 8-bit colour PNG with alpha, such as a projected image read back: CV_8UC4 BGRA, colours under
/// alpha 0 as they were written. The size is the file's own, up to 2^28 px.
Decoded decode_bgra(std::span<const std::uint8_t> file);

}  // namespace nadir::image_io
