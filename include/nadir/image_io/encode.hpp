// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Images to JPEG and PNG.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace nadir::image_io {

enum class Chroma { halved, full };  ///< 4:2:0 or 4:4:4

/// CV_8UC1 or CV_8UC3 BGR, at most 65535 px per side; quality 1 to 100.
std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality,
                                      Chroma chroma = Chroma::halved);

/// How hard a PNG is compressed.
enum class PngEffort {
  fast,
  small,  ///< by encode_png four times the time for 7 % less, measured on photographs; PngWriter
          ///< gains 1 %
};

/// CV_8UC1, CV_8UC3 BGR, CV_8UC4 BGRA (alpha not premultiplied) or CV_16UC1.
std::vector<std::uint8_t> encode_png(const cv::Mat& image, PngEffort effort = PngEffort::fast);

/// A PNG written strip by strip, for a raster too large for memory. The sink takes each
/// piece of the file in order, returns false when it could not, and must not throw; after that
/// nothing more is sent to it.
class PngWriter {
 public:
  using Sink = std::function<bool(std::span<const std::uint8_t>)>;

  /// channels: 1, 3 (BGR) or 4 (BGRA), 8 bits each; 16 bits with channels 1 only.
  PngWriter(int width, int height, int channels, Sink sink, PngEffort effort = PngEffort::fast,
            int bits = 8);
  ~PngWriter();
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  /// The next rows from the top; false once the sink failed.
  [[nodiscard]] bool rows(const cv::Mat& strip);
  /// Ends the file; all rows must have been given. False when the sink failed at any time.
  [[nodiscard]] bool finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nadir::image_io
