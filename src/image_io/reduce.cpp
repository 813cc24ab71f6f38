// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/reduce.hpp"

#include <opencv2/imgproc.hpp>

namespace nadir::image_io {

// The last column and row of a size that is not a multiple are averaged with copies of themselves.
cv::Mat reduce(const cv::Mat& image, int divisor) {
  if (divisor == 1 || image.empty()) return image;
  const int columns = (image.cols + divisor - 1) / divisor;
  const int rows = (image.rows + divisor - 1) / divisor;
  const int missing_rows = rows * divisor - image.rows;
  const int missing_columns = columns * divisor - image.cols;
  cv::Mat whole = image, reduced;
  if (missing_rows + missing_columns > 0) {
    cv::copyMakeBorder(image, whole, 0, missing_rows, 0, missing_columns, cv::BORDER_REPLICATE);
  }
  cv::resize(whole, reduced, {columns, rows}, 0, 0, cv::INTER_AREA);
  return reduced;
}

}  // namespace nadir::image_io
