// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// JPEG, PNG and TIFF files to images.
#pragma once

#include <cstdint>
#include <istream>
#include <memory>
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

/// Such a PNG read strip by strip, for a raster too large for memory.
class PngReader {
 public:
  /// The stream must outlive it.
  explicit PngReader(std::istream& file);
  ~PngReader();
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// Px, up to 2^20 a side; 0 when the file is none of the kind.
  int width() const;
  int height() const;
  /// Fills the strip, CV_8UC4 of the raster's width, with the next rows from the top. False when
  /// the file is damaged or has not as many.
  [[nodiscard]] bool rows(cv::Mat& strip);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::image_io
