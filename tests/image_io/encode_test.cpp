// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/encode.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::File, samples::gradient, samples::largest_difference;

enum class Content { flat, smooth, noise };

cv::Mat picture(cv::Size size, int type, Content content) {
  if (content == Content::smooth) return gradient(size.width, size.height, type);
  cv::Mat image(size, type, cv::Scalar::all(7));
  if (content == Content::noise)
    cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, image.depth() == CV_16U ? 65536 : 256);
  return image;
}

cv::Mat in_file_order(const cv::Mat& image) {
  cv::Mat ordered = image.clone();
  if (image.channels() == 3) cv::cvtColor(image, ordered, cv::COLOR_BGR2RGB);
  if (image.channels() == 4) cv::cvtColor(image, ordered, cv::COLOR_BGRA2RGBA);
  return ordered;
}

File in_strips(const cv::Mat& image, int rows_at_once, PngEffort effort) {
  File file;
  PngWriter writer(
      image.cols, image.rows, image.channels(),
      [&](std::span<const std::uint8_t> piece) {
        file.insert(file.end(), piece.begin(), piece.end());
        return true;
      },
      effort, image.depth() == CV_16U ? 16 : 8);
  for (int row = 0; row < image.rows; row += rows_at_once)
    EXPECT_TRUE(writer.rows(image.rowRange(row, std::min(row + rows_at_once, image.rows))));
  EXPECT_TRUE(writer.finish());
  return file;
}

// Rows narrower and wider than a block of the encoder, files smaller and larger than a chunk.
TEST(Encode, WritesEverySizeTypeAndContentWithoutLoss) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    for (const cv::Size size : {cv::Size(1, 1), {37, 1}, {1, 50}, {301, 333}, {70001, 3}}) {
      for (const Content content : {Content::flat, Content::smooth, Content::noise}) {
        const cv::Mat image = picture(size, type, content), expected = in_file_order(image);
        for (const PngEffort effort : {PngEffort::fast, PngEffort::small}) {
          for (const File& file : {encode_png(image, effort), in_strips(image, 7, effort),
                                   in_strips(image, image.rows, effort)}) {
            const cv::Mat pixels = samples::raw_pixels(file);
            ASSERT_EQ(pixels.size(), size);
            ASSERT_EQ(pixels.type(), type);
            EXPECT_EQ(largest_difference(pixels, expected), 0) << size << " type " << type;
          }
        }
      }
    }
  }
}

TEST(Encode, WritesTheSameBytesWhateverWasWrittenBefore) {
  const cv::Mat image = picture({301, 333}, CV_8UC4, Content::noise);
  const File first = encode_png(image);
  (void)encode_png(picture({500, 200}, CV_8UC3, Content::smooth));
  EXPECT_EQ(encode_png(image), first);
}

// A mosaic written twice is the same. The fault of ISA-L that png_stream.cpp works around shows
// here in every second run.
TEST(PngWriter, WritesTheSameBytesWhereverItsMemoryLies) {
  cv::Mat image(16, 1200, CV_8UC4, cv::Scalar::all(0));
  cv::RNG(3).fill(image({600, 8, 600, 8}), cv::RNG::UNIFORM, 0, 4);
  const File first = in_strips(image, 16, PngEffort::fast);
  std::vector<std::unique_ptr<std::uint8_t[]>> elsewhere;
  for (int i = 0; i < 2000; ++i) {
    elsewhere.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(1 << 17));
    ASSERT_EQ(in_strips(image, 16, PngEffort::fast), first) << i;
  }
}

TEST(Encode, WritesPartOfALargerImage) {
  const cv::Mat part = gradient(80, 60)({10, 20, 33, 17});
  const Decoded decoded = decode(encode_png(part), 33, 17, 1, Colour::bgr);
  ASSERT_EQ(decoded.fault, "");
  EXPECT_EQ(largest_difference(decoded.image, part), 0);
  const Decoded jpeg = decode(encode_jpeg(part, 95, Chroma::full), 33, 17, 1, Colour::bgr);
  ASSERT_EQ(jpeg.fault, "");
  EXPECT_LE(largest_difference(jpeg.image, part), 6);
}

TEST(Encode, WritesTheSamePixelsWithEitherEffort) {
  const cv::Mat image = gradient(80, 60);
  const Decoded decoded = decode(encode_png(image, PngEffort::small), 80, 60, 1, Colour::bgr);
  EXPECT_EQ(largest_difference(decoded.image, image), 0);
}

TEST(Encode, KeepsAlphaAndTheColoursUnderIt) {
  cv::Mat image = gradient(50, 40, CV_8UC4);
  image.at<cv::Vec4b>(3, 5) = {9, 8, 7, 0};
  const Decoded decoded = decode_bgra(encode_png(image));
  ASSERT_EQ(decoded.fault, "");
  EXPECT_EQ(largest_difference(decoded.image, image), 0);
  EXPECT_EQ(decoded.image.at<cv::Vec4b>(3, 5), cv::Vec4b(9, 8, 7, 0));
  EXPECT_NE(decode_bgra(encode_png(gradient(50, 40))).fault, "");
}

TEST(Encode, HalvesChromaOnlyWhenAsked) {
  cv::Mat stripes(32, 32, CV_8UC3, cv::Scalar(20, 20, 220));
  for (int x = 0; x < 32; x += 2) stripes.col(x).setTo(cv::Scalar(220, 20, 20));
  const auto error = [&](Chroma chroma) {
    const Decoded decoded = decode(encode_jpeg(stripes, 95, chroma), 32, 32, 1, Colour::bgr);
    return largest_difference(decoded.image, stripes);
  };
  EXPECT_LE(error(Chroma::full), 25);
  EXPECT_GE(error(Chroma::halved), 60);
}

TEST(PngWriter, WritesInStripsWhatWasGiven) {
  const cv::Mat image = gradient(50, 40, CV_8UC4);
  File file;
  PngWriter writer(50, 40, 4, [&](std::span<const std::uint8_t> piece) {
    file.insert(file.end(), piece.begin(), piece.end());
    return true;
  });
  for (int row = 0; row < 40; row += 8) EXPECT_TRUE(writer.rows(image.rowRange(row, row + 8)));
  EXPECT_TRUE(writer.finish());
  cv::Mat opaque;
  cv::cvtColor(image, opaque, cv::COLOR_BGRA2BGR);
  const Decoded decoded = decode(file, 50, 40, 1, Colour::bgr);
  ASSERT_EQ(decoded.fault, "");
  EXPECT_EQ(largest_difference(decoded.image, opaque), 0);
}

TEST(PngWriter, WritesSixteenBits) {
  cv::Mat image = gradient(50, 40, CV_16UC1);
  image.at<std::uint16_t>(3, 4) = 0x1234;
  File file;
  PngWriter writer(
      50, 40, 1,
      [&](std::span<const std::uint8_t> piece) {
        file.insert(file.end(), piece.begin(), piece.end());
        return true;
      },
      PngEffort::small, 16);
  EXPECT_TRUE(writer.rows(image));
  EXPECT_TRUE(writer.finish());
  EXPECT_EQ(largest_difference(samples::raw_pixels(file), image), 0);
  EXPECT_EQ(largest_difference(samples::raw_pixels(encode_png(image)), image), 0);
}

TEST(Encode, LeavesTheImageAsItWas) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    const cv::Mat image = gradient(50, 40, type), before = image.clone();
    (void)encode_png(image);
    EXPECT_EQ(largest_difference(image, before), 0);
  }
}

TEST(Encode, KeepsAlpha) {
  cv::Mat image = gradient(50, 40, CV_8UC4);
  image.at<cv::Vec4b>(3, 4) = {10, 20, 30, 0};
  const cv::Mat raw = samples::raw_pixels(encode_png(image));
  EXPECT_EQ(raw.at<cv::Vec4b>(3, 4), cv::Vec4b(30, 20, 10, 0));
}

TEST(PngWriter, ReportsAFullDiskAndSendsNothingMore) {
  cv::Mat image(300, 400, CV_8UC3);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
  std::size_t taken = 0, calls_after_failure = 0;
  bool failed = false;
  PngWriter writer(400, 300, 3, [&](std::span<const std::uint8_t> piece) {
    if (failed) ++calls_after_failure;
    taken += piece.size();
    failed = taken > 9000;
    return !failed;
  });
  EXPECT_FALSE(writer.rows(image));
  EXPECT_FALSE(writer.rows(image));
  EXPECT_FALSE(writer.finish());
  EXPECT_EQ(calls_after_failure, 0u);
}

TEST(PngWriter, ReportsASinkThatFailsAtItsFirstByte) {
  PngWriter writer(4, 3, 3, [](std::span<const std::uint8_t>) { return false; });
  EXPECT_FALSE(writer.rows(gradient(4, 3)));
  EXPECT_FALSE(writer.finish());
}

TEST(PngWriter, RefusesToEndBeforeAllRowsAreGiven) {
  PngWriter writer(4, 3, 3, [](std::span<const std::uint8_t>) { return true; });
  EXPECT_TRUE(writer.rows(gradient(4, 2)));
  EXPECT_THROW((void)writer.finish(), ContractError);
}

}  // namespace
}  // namespace nadir::image_io
