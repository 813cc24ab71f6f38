// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nadir/image_io/encode.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::File, samples::gradient, samples::largest_difference;
using ::testing::HasSubstr;

constexpr int kWidth = 61, kHeight = 43;

Decoded decode_all(const File& file, Colour colour = Colour::bgr) {
  return decode(file, kWidth, kHeight, 1, colour);
}

cv::Mat rgb(const cv::Mat& bgr) {
  cv::Mat swapped;
  cv::cvtColor(bgr, swapped, cv::COLOR_BGR2RGB);
  return swapped;
}

TEST(Decode, KeepsTheColoursOfAJpeg) {
  const cv::Mat image = gradient(kWidth, kHeight);
  const Decoded decoded = decode_all(encode_jpeg(image, 95, Chroma::full));
  ASSERT_EQ(decoded.fault, "");
  EXPECT_LE(largest_difference(decoded.image, image), 6);
}

TEST(Decode, KeepsEveryBitOfAPng) {
  const cv::Mat image = gradient(kWidth, kHeight);
  const Decoded decoded = decode_all(encode_png(image));
  ASSERT_EQ(decoded.fault, "");
  EXPECT_EQ(largest_difference(decoded.image, image), 0);
}

TEST(Decode, GivesThreeEqualChannelsForAGreyFile) {
  const cv::Mat grey = gradient(kWidth, kHeight, CV_8UC1);
  cv::Mat expected;
  cv::cvtColor(grey, expected, cv::COLOR_GRAY2BGR);
  for (const File& file : {encode_png(grey), samples::raw_tiff(grey, {})}) {
    const Decoded decoded = decode_all(file);
    ASSERT_EQ(decoded.fault, "");
    EXPECT_EQ(largest_difference(decoded.image, expected), 0);
  }
  const Decoded jpeg = decode_all(encode_jpeg(grey, 95));
  ASSERT_EQ(jpeg.fault, "");
  EXPECT_LE(largest_difference(jpeg.image, expected), 4);
}

TEST(Decode, GivesTheSameGreyFromEveryColourFile) {
  const cv::Mat image = gradient(kWidth, kHeight), expected = gradient(kWidth, kHeight, CV_8UC1);
  const File files[] = {encode_jpeg(image, 98, Chroma::full), encode_png(image),
                        samples::raw_tiff(rgb(image), {PHOTOMETRIC_RGB})};
  for (const File& file : files) {
    const Decoded decoded = decode_all(file, Colour::grey);
    ASSERT_EQ(decoded.fault, "");
    EXPECT_LE(largest_difference(decoded.image, expected), 2);
  }
}

TEST(Decode, ReadsInterlacedPaletteAlphaAndSixteenBitPngs) {
  const cv::Mat image = gradient(kWidth, kHeight), grey = gradient(kWidth, kHeight, CV_8UC1);
  const Decoded interlaced = decode_all(samples::raw_png(rgb(image), PNG_COLOR_TYPE_RGB, true));
  ASSERT_EQ(interlaced.fault, "");
  EXPECT_EQ(largest_difference(interlaced.image, image), 0);

  const Decoded palette = decode_all(samples::raw_png(grey, PNG_COLOR_TYPE_PALETTE, false));
  ASSERT_EQ(palette.fault, "");
  const int index = grey.at<std::uint8_t>(5, 7);
  EXPECT_EQ(palette.image.at<cv::Vec3b>(5, 7),
            cv::Vec3b(7, static_cast<uchar>(255 - index), static_cast<uchar>(index)));

  const Decoded alpha = decode_all(encode_png(gradient(kWidth, kHeight, CV_8UC4)));
  ASSERT_EQ(alpha.fault, "");
  EXPECT_EQ(largest_difference(alpha.image, image), 0);

  const Decoded deep = decode_all(encode_png(gradient(kWidth, kHeight, CV_16UC1)), Colour::grey);
  ASSERT_EQ(deep.fault, "");
  EXPECT_EQ(largest_difference(deep.image, grey), 0);
}

TEST(Decode, ReadsTheTiffsOfCamerasAndPhotogrammetry) {
  const cv::Mat image = gradient(kWidth, kHeight), grey = gradient(kWidth, kHeight, CV_8UC1);
  cv::Mat rgba;
  cv::cvtColor(image, rgba, cv::COLOR_BGR2RGBA);
  const File colour_files[] = {
      samples::raw_tiff(rgb(image), {PHOTOMETRIC_RGB, COMPRESSION_LZW}),
      samples::raw_tiff(rgb(image), {PHOTOMETRIC_RGB, COMPRESSION_ADOBE_DEFLATE, true}),
      samples::raw_tiff(rgb(image), {PHOTOMETRIC_RGB, COMPRESSION_PACKBITS}),
      samples::raw_tiff(rgba, {PHOTOMETRIC_RGB, COMPRESSION_NONE, true})};
  for (const File& file : colour_files) {
    const Decoded decoded = decode_all(file);
    ASSERT_EQ(decoded.fault, "");
    EXPECT_EQ(largest_difference(decoded.image, image), 0);
  }
  cv::Mat white_is_zero;
  cv::bitwise_not(grey, white_is_zero);
  const File grey_files[] = {samples::raw_tiff(gradient(kWidth, kHeight, CV_16UC1), {}),
                             samples::raw_tiff(white_is_zero, {PHOTOMETRIC_MINISWHITE})};
  for (const File& file : grey_files) {
    const Decoded decoded = decode_all(file, Colour::grey);
    ASSERT_EQ(decoded.fault, "");
    EXPECT_EQ(largest_difference(decoded.image, grey), 0);
  }
  const Decoded jpeg_in_tiff =
      decode_all(samples::raw_tiff(rgb(image), {PHOTOMETRIC_YCBCR, COMPRESSION_JPEG}));
  ASSERT_EQ(jpeg_in_tiff.fault, "");
  EXPECT_LE(largest_difference(jpeg_in_tiff.image, image), 25);
}

TEST(Decode, NeverRotatesByExifOrientation) {
  const cv::Mat image = gradient(kWidth, kHeight);
  const File file = samples::with_segment(encode_jpeg(image, 95, Chroma::full), 0xe1,
                                          samples::exif("2020:01:02 03:04:05", "", 6));
  const Decoded decoded = decode_all(file);
  ASSERT_EQ(decoded.fault, "");
  EXPECT_LE(largest_difference(decoded.image, image), 6);
}

TEST(Decode, IgnoresWhatFollowsTheEndOfAJpeg) {
  const cv::Mat image = gradient(kWidth, kHeight);
  File file = encode_jpeg(image, 95, Chroma::full);
  for (int i = 0; i < 100; ++i)
    file.insert(file.end(), {0xff, 0xda, 0x00, 0x02});  // a phone's video
  const Decoded decoded = decode_all(file);
  ASSERT_EQ(decoded.fault, "");
  EXPECT_LE(largest_difference(decoded.image, image), 6);
}

TEST(Decode, RefusesAnotherSizeNamingBoth) {
  const Decoded decoded =
      decode(encode_jpeg(gradient(kHeight, kWidth), 80), kWidth, kHeight, 1, Colour::bgr);
  EXPECT_TRUE(decoded.image.empty());
  EXPECT_THAT(decoded.fault, HasSubstr("43 x 61 px"));
  EXPECT_THAT(decoded.fault, HasSubstr("61 x 43 px"));
}

// Where a pixel is after the reduction decides the principal point: the centroid of a blob must
// move as CameraModel::reduced says, (x + 0.5) / divisor - 0.5.
TEST(Decode, ReducesByAveragingPixelAreas) {
  cv::Mat image(96, 128, CV_8UC1, cv::Scalar(0));
  const cv::Point2d centre(61.3, 40.8);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double r2 = (x - centre.x) * (x - centre.x) + (y - centre.y) * (y - centre.y);
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(230 * std::exp(-r2 / 128));
    }
  }
  for (const File& file : {encode_jpeg(image, 98), encode_png(image)}) {
    for (const int divisor : {1, 2, 4}) {
      const Decoded decoded = decode(file, image.cols, image.rows, divisor, Colour::grey);
      ASSERT_EQ(decoded.fault, "");
      cv::Mat blob;
      cv::threshold(decoded.image, blob, 8, 0, cv::THRESH_TOZERO);
      const cv::Moments m = cv::moments(blob);
      EXPECT_NEAR(m.m10 / m.m00, (centre.x + 0.5) / divisor - 0.5, 0.03);
      EXPECT_NEAR(m.m01 / m.m00, (centre.y + 0.5) / divisor - 0.5, 0.03);
    }
  }
}

TEST(Decode, RoundsAReducedSizeUp) {
  const cv::Mat image = gradient(kWidth, kHeight);
  for (const File& file : {encode_jpeg(image, 90), encode_png(image)}) {
    for (const int divisor : {2, 4}) {
      const Decoded decoded = decode(file, kWidth, kHeight, divisor, Colour::bgr);
      ASSERT_EQ(decoded.fault, "");
      EXPECT_EQ(decoded.image.cols, (kWidth + divisor - 1) / divisor);
      EXPECT_EQ(decoded.image.rows, (kHeight + divisor - 1) / divisor);
      EXPECT_EQ(decoded.image.type(), CV_8UC3);
    }
  }
}

}  // namespace
}  // namespace nadir::image_io
