// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/raw.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "nadir/image_io/reduce.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::largest_difference;
using Bytes = std::vector<std::uint8_t>;

constexpr int kWidth = 64, kHeight = 48;
constexpr std::size_t kPadding = 13;

// Colours that change slowly, so that halved colour planes and missing colours cost little.
cv::Mat slow_colours() {
  cv::Mat bgr(kHeight, kWidth, CV_8UC3);
  bgr.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int* at) {
    const int y = at[0], x = at[1];
    pixel = cv::Vec3i(60 + x, 80 + 2 * y, 150 - x);
  });
  return bgr;
}

// Y, U and V of BT.601, 16 to 235 (ITU-R BT.601-7, 2.5).
std::array<double, 3> yuv(const cv::Vec3b& bgr) {
  const double b = bgr[0], g = bgr[1], r = bgr[2];
  const double y = 0.299 * r + 0.587 * g + 0.114 * b;
  return {16 + 219 * y / 255, 128 + 224 * (b - y) / 1.772 / 255, 128 + 224 * (r - y) / 1.402 / 255};
}
std::uint8_t byte(double value) { return cv::saturate_cast<std::uint8_t>(value); }

struct Sample {
  Bytes bytes;
  std::size_t stride;
  RawImage image(RawFormat format, BayerOrder order = {}) const {
    return {format, order, kWidth, kHeight, stride, bytes};
  }
};

Sample sample(std::size_t row, std::size_t rows = kHeight) {
  const std::size_t stride = row + kPadding;
  return {Bytes(stride * rows - kPadding, 0xEE), stride};
}

Sample as_yuyv(const cv::Mat& bgr) {
  Sample made = sample(2 * kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto pixel = yuv(bgr.at<cv::Vec3b>(y, x));
      std::uint8_t* to = made.bytes.data() + static_cast<std::size_t>(y) * made.stride + 2 * x;
      to[0] = byte(pixel[0]);
      to[1] = byte(pixel[x % 2 == 0 ? 1 : 2]);
    }
  }
  return made;
}

Sample as_nv12(const cv::Mat& bgr) {
  Sample made = sample(kWidth, kHeight + kHeight / 2);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto pixel = yuv(bgr.at<cv::Vec3b>(y, x));
      const auto row = [&](int r) {
        return made.bytes.data() + static_cast<std::size_t>(r) * made.stride;
      };
      row(y)[x] = byte(pixel[0]);
      if (y % 2 == 0) row(kHeight + y / 2)[x] = byte(pixel[x % 2 == 0 ? 1 : 2]);
    }
  }
  return made;
}

Sample as_rgb(const cv::Mat& bgr, RawFormat format) {
  Sample made = sample(3 * kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      std::uint8_t* to = made.bytes.data() + static_cast<std::size_t>(y) * made.stride + 3 * x;
      for (int c = 0; c < 3; ++c)
        to[c] = bgr.at<cv::Vec3b>(y, x)[format == RawFormat::bgr24 ? c : 2 - c];
    }
  }
  return made;
}

// The channel of OpenCV's BGR that the pattern has there.
int channel(BayerOrder order, int x, int y) {
  static constexpr std::array<const char*, 4> kNames{"RGGB", "GRBG", "GBRG", "BGGR"};
  const char c = kNames[static_cast<std::size_t>(order)][2 * (y % 2) + x % 2];
  return c == 'B' ? 0 : c == 'G' ? 1 : 2;
}

Sample as_bayer(const cv::Mat& bgr, RawFormat format, BayerOrder order) {
  const std::size_t row = format == RawFormat::bayer8    ? kWidth
                          : format == RawFormat::bayer10 ? 2 * kWidth
                                                         : kWidth * 5 / 4;
  Sample made = sample(row);
  for (int y = 0; y < kHeight; ++y) {
    std::uint8_t* to = made.bytes.data() + static_cast<std::size_t>(y) * made.stride;
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t value = bgr.at<cv::Vec3b>(y, x)[channel(order, x, y)];
      if (format == RawFormat::bayer8) to[x] = value;
      if (format == RawFormat::bayer10) {
        to[2 * x] = static_cast<std::uint8_t>(value << 2 | 3);  // low bits that are left out
        to[2 * x + 1] = static_cast<std::uint8_t>(value >> 6);
      }
      if (format == RawFormat::bayer10p) to[x + x / 4] = value;
    }
  }
  return made;
}

void expect_colours(const Decoded& decoded, const cv::Mat& bgr, int divisor, double tolerance,
                    int border = 0) {
  ASSERT_EQ(decoded.fault, "");
  const cv::Mat expected = reduce(bgr, divisor);
  ASSERT_EQ(decoded.image.size(), expected.size());
  const cv::Rect inner(border, border, expected.cols - 2 * border, expected.rows - 2 * border);
  EXPECT_LE(largest_difference(decoded.image(inner), expected(inner)), tolerance) << divisor;
}

TEST(Raw, KeepsColoursOfYuvWithinItsRounding) {
  const cv::Mat bgr = slow_colours();
  for (const int divisor : {1, 2, 4}) {
    // A step of Y is 1.2, of U or V up to 2; their halves, and neighbours that share U and V.
    expect_colours(decode_raw(as_yuyv(bgr).image(RawFormat::yuyv), divisor, Colour::bgr), bgr,
                   divisor, 5);
    expect_colours(decode_raw(as_nv12(bgr).image(RawFormat::nv12), divisor, Colour::bgr), bgr,
                   divisor, 5);
  }
}

TEST(Raw, KeepsColoursOfEveryBayerPattern) {
  const cv::Mat bgr = slow_colours();
  for (const auto format : {RawFormat::bayer8, RawFormat::bayer10, RawFormat::bayer10p}) {
    for (const auto order :
         {BayerOrder::rggb, BayerOrder::grbg, BayerOrder::gbrg, BayerOrder::bggr}) {
      const Sample made = as_bayer(bgr, format, order);
      for (const int divisor : {1, 2, 4}) {
        SCOPED_TRACE(std::string(to_string(format)) + ' ' + std::to_string(int(order)));
        // Colours are taken from neighbours 2 grey levels away; those of the border from inside.
        expect_colours(decode_raw(made.image(format, order), divisor, Colour::bgr), bgr, divisor, 2,
                       divisor == 1 ? 1 : 0);
      }
    }
  }
}

TEST(Raw, KeepsRgbAsItIsAndItsOwnMemory) {
  const cv::Mat bgr = slow_colours();
  for (const auto format : {RawFormat::bgr24, RawFormat::rgb24}) {
    for (const int divisor : {1, 2, 4}) {
      Sample made = as_rgb(bgr, format);
      const Decoded decoded = decode_raw(made.image(format), divisor, Colour::bgr);
      std::fill(made.bytes.begin(), made.bytes.end(), std::uint8_t{0});  // the camera writes on
      expect_colours(decoded, bgr, divisor, 0);
    }
  }
}

TEST(Raw, KeepsGreyAndItsOwnMemory) {
  cv::Mat grey;
  cv::cvtColor(slow_colours(), grey, cv::COLOR_BGR2GRAY);
  Sample made = sample(kWidth);
  for (int y = 0; y < kHeight; ++y)
    std::copy_n(grey.ptr(y), kWidth,
                made.bytes.begin() + static_cast<std::ptrdiff_t>(made.stride) * y);
  const Decoded decoded = decode_raw(made.image(RawFormat::grey), 1, Colour::grey);
  std::fill(made.bytes.begin(), made.bytes.end(), std::uint8_t{0});  // the camera writes on
  EXPECT_EQ(largest_difference(decoded.image, grey), 0);
}

TEST(Raw, GreyIsThatOfTheColours) {
  const Sample made = as_yuyv(slow_colours());
  cv::Mat expected;
  cv::cvtColor(decode_raw(made.image(RawFormat::yuyv), 2, Colour::bgr).image, expected,
               cv::COLOR_BGR2GRAY);
  const Decoded grey = decode_raw(made.image(RawFormat::yuyv), 2, Colour::grey);
  EXPECT_EQ(largest_difference(grey.image, expected), 0);
}

TEST(Raw, RefusesWhatIsTooShortOrHasNoPairs) {
  const Sample made = as_nv12(slow_colours());
  RawImage image = made.image(RawFormat::nv12);
  EXPECT_EQ(decode_raw(image, 1, Colour::bgr).fault, "");
  image.bytes = image.bytes.first(image.bytes.size() - 1);
  EXPECT_NE(decode_raw(image, 1, Colour::bgr).fault.find("holds 5530 of 5531 bytes"),
            std::string::npos)
      << decode_raw(image, 1, Colour::bgr).fault;
  image = made.image(RawFormat::nv12);
  image.height = kHeight - 1;
  EXPECT_NE(decode_raw(image, 1, Colour::bgr).fault.find("pairs"), std::string::npos);
  image = made.image(RawFormat::yuyv);
  EXPECT_NE(decode_raw(image, 1, Colour::bgr).fault.find("rows of 77 bytes"), std::string::npos);
  image.width = 0;
  EXPECT_NE(decode_raw(image, 1, Colour::bgr).fault, "");
}

}  // namespace
}  // namespace nadir::image_io
