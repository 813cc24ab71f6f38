// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/header.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nadir/image_io/encode.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::File;
using ::testing::HasSubstr;

File text(std::string_view content) { return {content.begin(), content.end()}; }

TEST(Header, TellsSizeChannelsAndBitsOfAJpeg) {
  const auto header = read_header(encode_jpeg(samples::gradient(37, 21), 80)).header;
  ASSERT_TRUE(header);
  EXPECT_EQ(header->format, Format::jpeg);
  EXPECT_EQ(header->width, 37);
  EXPECT_EQ(header->height, 21);
  EXPECT_EQ(header->channels, 3);
  EXPECT_EQ(header->bits, 8);
}

TEST(Header, TellsSizeChannelsAndBitsOfAPng) {
  const auto header = read_header(encode_png(samples::gradient(37, 21, CV_16UC1))).header;
  ASSERT_TRUE(header);
  EXPECT_EQ(header->format, Format::png);
  EXPECT_EQ(header->width, 37);
  EXPECT_EQ(header->height, 21);
  EXPECT_EQ(header->channels, 1);
  EXPECT_EQ(header->bits, 16);
}

TEST(Header, TellsSizeChannelsAndBitsOfATiff) {
  const auto header =
      read_header(samples::raw_tiff(samples::gradient(37, 21), {PHOTOMETRIC_RGB, COMPRESSION_LZW}))
          .header;
  ASSERT_TRUE(header);
  EXPECT_EQ(header->format, Format::tiff);
  EXPECT_EQ(header->width, 37);
  EXPECT_EQ(header->height, 21);
  EXPECT_EQ(header->channels, 3);
  EXPECT_EQ(header->bits, 8);
}

TEST(Header, FindsAJpegFrameBehindManyLongSegments) {
  File file = encode_jpeg(samples::gradient(16, 8), 80);
  for (int i = 0; i < 40; ++i) file = samples::with_segment(file, 0xe5, File(65533, 0xff));
  const auto header = read_header(file).header;
  ASSERT_TRUE(header);
  EXPECT_EQ(header->width, 16);
}

TEST(Header, RefusesWhatIsNotSupportedByName) {
  File twelve_bit = encode_jpeg(samples::gradient(16, 8), 80);
  twelve_bit[samples::find_marker(twelve_bit, 0xc0) + 4] = 12;
  EXPECT_THAT(read_header(twelve_bit).fault, HasSubstr("12-bit JPEG"));
  EXPECT_THAT(read_header(samples::cmyk_jpeg(16, 8)).fault, HasSubstr("CMYK"));
  File lossless = encode_jpeg(samples::gradient(16, 8), 80);
  lossless[samples::find_marker(lossless, 0xc0) + 1] = 0xc3;
  EXPECT_THAT(read_header(lossless).fault, HasSubstr("lossless"));
  EXPECT_THAT(read_header(samples::raw_tiff(cv::Mat::zeros(8, 16, CV_8UC4),
                                            {PHOTOMETRIC_SEPARATED, COMPRESSION_NONE}))
                  .fault,
              HasSubstr("CMYK"));
  EXPECT_THAT(read_header(samples::raw_tiff(cv::Mat::zeros(8, 16, CV_32SC1), {})).fault,
              HasSubstr("32-bit TIFF"));
}

TEST(Header, RefusesOtherImageFormatsByName) {
  File dicom(132, 0);
  std::copy_n("DICM", 4, dicom.begin() + 128);
  EXPECT_THAT(read_header(dicom).fault, HasSubstr("DICOM"));
  EXPECT_THAT(read_header(text("\x76\x2f\x31\x01 more")).fault, HasSubstr("OpenEXR"));
  EXPECT_THAT(read_header(text("#?RADIANCE\n")).fault, HasSubstr("Radiance"));
  EXPECT_THAT(read_header(text("\x59\xa6\x6a\x95")).fault, HasSubstr("Sun raster"));
  EXPECT_THAT(read_header(text("GIF89a")).fault, HasSubstr("GIF"));
  EXPECT_THAT(read_header(text("BMxxxx")).fault, HasSubstr("BMP"));
  EXPECT_THAT(read_header(text("RIFF0000WEBPVP8 ")).fault, HasSubstr("WebP"));
  EXPECT_THAT(read_header(text("....jP  ")).fault, HasSubstr("JPEG 2000"));
  EXPECT_THAT(read_header(text("....ftypheic")).fault, HasSubstr("HEIF"));
  EXPECT_THAT(read_header(text("Pf\n1 1\n")).fault, HasSubstr("PNM"));
  EXPECT_THAT(read_header(text("II+")).fault, HasSubstr("BigTIFF"));
  EXPECT_THAT(read_header({}).fault, HasSubstr("empty"));
  EXPECT_THAT(read_header(text("x")).fault, HasSubstr("not a JPEG"));
}

TEST(Header, RefusesAnImageWithoutArea) {
  File file = encode_png(samples::gradient(16, 8, CV_8UC1));
  std::fill_n(file.begin() + 16, 4, std::uint8_t{0});
  EXPECT_THAT(read_header(file).fault, HasSubstr("impossible"));
}

}  // namespace
}  // namespace nadir::image_io
