// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "png_rows.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace nadir::image_io {
namespace {

// Channels and bytes in PNG's order; ordered has the rows' type and size.
void put_in_order(const cv::Mat& rows, cv::Mat ordered) {
  if (rows.type() == CV_8UC1) rows.copyTo(ordered);
  if (rows.type() == CV_8UC3) cv::cvtColor(rows, ordered, cv::COLOR_BGR2RGB);
  if (rows.type() == CV_8UC4) cv::cvtColor(rows, ordered, cv::COLOR_BGRA2RGBA);
  if (rows.type() == CV_16UC1) {
    for (int row = 0; row < rows.rows; ++row) {
      const auto* from = rows.ptr<std::uint16_t>(row);
      std::uint8_t* to = ordered.ptr(row);
      for (int column = 0; column < rows.cols; ++column) {
        *to++ = static_cast<std::uint8_t>(from[column] >> 8);
        *to++ = static_cast<std::uint8_t>(from[column]);
      }
    }
  }
}

// A function of its own: bytes written could be anything else's, but not a parameter's.
void subtract(const std::uint8_t* from, const std::uint8_t* above, std::size_t size,
              std::uint8_t* to) {
  for (std::size_t i = 0; i < size; ++i) to[i] = static_cast<std::uint8_t>(from[i] - above[i]);
}

}  // namespace

void PngRows::start(int width, int type, int most_rows) {
  row_size_ = static_cast<std::size_t>(width) * CV_ELEM_SIZE(type);
  ordered_.create(most_rows + 1, width, type);
  ordered_.row(0).setTo(cv::Scalar::all(0));  // what is above the first row
  filtered_.resize(static_cast<std::size_t>(most_rows) * (row_size_ + 1));
}

std::span<const std::uint8_t> PngRows::filtered(const cv::Mat& rows) {
  constexpr std::uint8_t kUp = 2;
  put_in_order(rows, ordered_.rowRange(1, 1 + rows.rows));
  std::uint8_t* to = filtered_.data();
  for (int row = 0; row < rows.rows; ++row) {
    const std::uint8_t* above = ordered_.ptr(row);
    const std::uint8_t* from = ordered_.ptr(row + 1);
    *to++ = kUp;
    subtract(from, above, row_size_, to);
    to += row_size_;
  }
  std::copy_n(ordered_.ptr(rows.rows), row_size_, ordered_.ptr(0));
  return {filtered_.data(), to};
}

}  // namespace nadir::image_io
