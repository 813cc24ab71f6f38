// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Pixels as a PNG compresses them: channels and bytes in its order, each row as the difference to
// the one above, after a byte that says so (filter UP, PNG 9.2).
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace nadir::image_io {

class PngRows {
 public:
  /// Rows of that width and type (CV_8UC1, CV_8UC3, CV_8UC4 or CV_16UC1) follow from the top, at
  /// most so many a time. Memory of the image before is used again.
  void start(int width, int type, int most_rows);

  /// The next rows; valid until the next call.
  std::span<const std::uint8_t> filtered(const cv::Mat& rows);

 private:
  std::size_t row_size_ = 0;
  cv::Mat ordered_;  // the last row of the call before, then this call's
  std::vector<std::uint8_t> filtered_;
};

}  // namespace nadir::image_io
