// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/raw.hpp"

#include <array>
#include <opencv2/imgproc.hpp>
#include <string>

#include "nadir/core/check.hpp"
#include "nadir/image_io/reduce.hpp"

namespace nadir::image_io {
namespace {

bool is_bayer(RawFormat format) {
  return format == RawFormat::bayer8 || format == RawFormat::bayer10 ||
         format == RawFormat::bayer10p;
}

bool is_rgb(RawFormat format) { return format == RawFormat::bgr24 || format == RawFormat::rgb24; }

std::size_t row_bytes(RawFormat format, int width) {
  const auto pixels = static_cast<std::size_t>(width);
  switch (format) {
    case RawFormat::grey:
    case RawFormat::nv12:
    case RawFormat::bayer8:
      return pixels;
    case RawFormat::yuyv:
    case RawFormat::bayer10:
      return 2 * pixels;
    case RawFormat::bgr24:
    case RawFormat::rgb24:
      return 3 * pixels;
    case RawFormat::bayer10p:
      return (pixels * 5 + 3) / 4;
  }
  return 0;
}

std::string fault_of(const RawImage& raw) {
  const std::string size = std::to_string(raw.width) + " x " + std::to_string(raw.height) + " px";
  if (raw.width < 1 || raw.height < 1) return "has no pixels: " + size;
  const bool pairs = raw.format != RawFormat::grey && !is_rgb(raw.format);
  const bool row_pairs = pairs && raw.format != RawFormat::yuyv;
  if ((pairs && raw.width % 2 != 0) || (row_pairs && raw.height % 2 != 0))
    return "is " + size + ", but " + std::string(to_string(raw.format)) + " has pairs of pixels";
  const std::size_t row = row_bytes(raw.format, raw.width);
  if (raw.stride < row) return "has rows of " + std::to_string(raw.stride) + " bytes for " + size;
  const auto height = static_cast<std::size_t>(raw.height);
  const std::size_t rows = raw.format == RawFormat::nv12 ? height + height / 2 : height;
  const std::size_t wanted = (rows - 1) * raw.stride + row;  // the last row may lack its padding
  if (raw.bytes.size() < wanted)
    return "holds " + std::to_string(raw.bytes.size()) + " of " + std::to_string(wanted) + " bytes";
  return {};
}

// A view of the bytes; OpenCV takes no pointers to what it may not write.
cv::Mat rows_of(const RawImage& raw, int first, int count, int columns, int type) {
  auto* data =
      const_cast<std::uint8_t*>(raw.bytes.data()) + static_cast<std::size_t>(first) * raw.stride;
  return {count, columns, type, data, raw.stride};
}

// The high eight of ten bits.
cv::Mat eight_bits(const RawImage& raw) {
  if (raw.format == RawFormat::bayer8) return rows_of(raw, 0, raw.height, raw.width, CV_8UC1);
  cv::Mat pixels(raw.height, raw.width, CV_8UC1);
  for (int y = 0; y < raw.height; ++y) {
    const std::uint8_t* from = raw.bytes.data() + static_cast<std::size_t>(y) * raw.stride;
    auto* to = pixels.ptr<std::uint8_t>(y);
    for (int x = 0; x < raw.width; ++x) {
      if (raw.format == RawFormat::bayer10p) {
        to[x] = from[static_cast<std::size_t>(x) + static_cast<std::size_t>(x) / 4];
      } else {
        const std::size_t at = 2 * static_cast<std::size_t>(x);
        to[x] = static_cast<std::uint8_t>((from[at] | from[at + 1] << 8) >> 2 & 0xFF);
      }
    }
  }
  return pixels;
}

struct Quad {
  int red, green, other_green, blue;  ///< places in rows of two: 0 1, 2 3
};
Quad quad_of(BayerOrder order) {
  switch (order) {
    case BayerOrder::rggb:
      return {0, 1, 2, 3};
    case BayerOrder::grbg:
      return {1, 0, 3, 2};
    case BayerOrder::gbrg:
      return {2, 0, 3, 1};
    case BayerOrder::bggr:
      return {3, 1, 2, 0};
  }
  return {};
}

// A pixel of the half size from each two by two: no colour is made up.
cv::Mat binned(const cv::Mat& pixels, BayerOrder order) {
  const Quad quad = quad_of(order);
  cv::Mat bgr(pixels.rows / 2, pixels.cols / 2, CV_8UC3);
  for (int y = 0; y < bgr.rows; ++y) {
    const std::array<const std::uint8_t*, 2> rows{pixels.ptr(2 * y), pixels.ptr(2 * y + 1)};
    auto* to = bgr.ptr<cv::Vec3b>(y);
    for (int x = 0; x < bgr.cols; ++x) {
      const auto at = [&](int place) -> unsigned {
        return rows[static_cast<std::size_t>(place / 2)][2 * x + place % 2];
      };
      to[x] = {static_cast<std::uint8_t>(at(quad.blue)),
               static_cast<std::uint8_t>((at(quad.green) + at(quad.other_green) + 1) / 2),
               static_cast<std::uint8_t>(at(quad.red))};
    }
  }
  return bgr;
}

cv::Mat demosaicked(const cv::Mat& pixels, BayerOrder order) {
  const auto code = [&] {
    switch (order) {
      case BayerOrder::rggb:
        return cv::COLOR_BayerRGGB2BGR;
      case BayerOrder::grbg:
        return cv::COLOR_BayerGRBG2BGR;
      case BayerOrder::gbrg:
        return cv::COLOR_BayerGBRG2BGR;
      case BayerOrder::bggr:
        break;
    }
    return cv::COLOR_BayerBGGR2BGR;
  }();
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr, code);
  return bgr;
}

// At the divisor's size.
cv::Mat colours(const RawImage& raw, int divisor) {
  if (is_bayer(raw.format)) {
    const cv::Mat pixels = eight_bits(raw);
    return divisor == 1 ? demosaicked(pixels, raw.order)
                        : reduce(binned(pixels, raw.order), divisor / 2);
  }
  cv::Mat bgr;
  if (is_rgb(raw.format)) {
    const cv::Mat pixels = rows_of(raw, 0, raw.height, raw.width, CV_8UC3);
    if (raw.format == RawFormat::rgb24) {
      cv::cvtColor(pixels, bgr, cv::COLOR_RGB2BGR);
    } else {
      bgr = divisor == 1 ? pixels.clone() : pixels;  // the bytes are the camera's
    }
  } else if (raw.format == RawFormat::yuyv) {
    cv::cvtColor(rows_of(raw, 0, raw.height, raw.width, CV_8UC2), bgr, cv::COLOR_YUV2BGR_YUYV);
  } else {
    cv::cvtColorTwoPlane(rows_of(raw, 0, raw.height, raw.width, CV_8UC1),
                         rows_of(raw, raw.height, raw.height / 2, raw.width / 2, CV_8UC2), bgr,
                         cv::COLOR_YUV2BGR_NV12);
  }
  return reduce(bgr, divisor);
}

}  // namespace

std::string_view to_string(RawFormat format) {
  switch (format) {
    case RawFormat::grey:
      return "grey";
    case RawFormat::yuyv:
      return "YUYV";
    case RawFormat::nv12:
      return "NV12";
    case RawFormat::bgr24:
      return "BGR24";
    case RawFormat::rgb24:
      return "RGB24";
    case RawFormat::bayer8:
      return "8-bit Bayer";
    case RawFormat::bayer10:
      return "10-bit Bayer";
    case RawFormat::bayer10p:
      return "packed 10-bit Bayer";
  }
  return "unknown";
}

Decoded decode_raw(const RawImage& raw, int divisor, Colour colour) {
  NADIR_CHECK(divisor == 1 || divisor == 2 || divisor == 4, divisor);
  if (const std::string fault = fault_of(raw); !fault.empty()) return {{}, fault};
  Decoded decoded;
  if (raw.format == RawFormat::grey) {
    const cv::Mat grey = reduce(rows_of(raw, 0, raw.height, raw.width, CV_8UC1), divisor);
    if (colour == Colour::grey) {
      decoded.image = divisor == 1 ? grey.clone() : grey;  // the bytes are the camera's
    } else {
      cv::cvtColor(grey, decoded.image, cv::COLOR_GRAY2BGR);
    }
    return decoded;
  }
  decoded.image = colours(raw, divisor);
  if (colour == Colour::grey) cv::cvtColor(decoded.image, decoded.image, cv::COLOR_BGR2GRAY);
  return decoded;
}

}  // namespace nadir::image_io
