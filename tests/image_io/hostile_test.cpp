// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Damaged and forged files: a fault, never a crash, never part of an image (faults B01 to B08).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>

#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/encode.hpp"
#include "nadir/image_io/header.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::File;
using ::testing::HasSubstr;

constexpr int kWidth = 40, kHeight = 24;

Decoded decode_small(std::span<const std::uint8_t> file) {
  return decode(file, kWidth, kHeight, 1, Colour::bgr);
}

std::vector<File> one_of_each() {
  const cv::Mat image = samples::gradient(kWidth, kHeight);
  return {encode_jpeg(image, 80),
          samples::progressive_jpeg(image),
          encode_png(image),
          samples::raw_png(image, PNG_COLOR_TYPE_RGB, true),
          samples::raw_tiff(image, {PHOTOMETRIC_RGB, COMPRESSION_LZW}),
          samples::raw_tiff(image, {PHOTOMETRIC_RGB, COMPRESSION_ADOBE_DEFLATE, true})};
}

TEST(Hostile, AFileCutShortAnywhereGivesAFault) {
  for (const File& file : one_of_each()) {
    ASSERT_EQ(decode_small(file).fault, "");
    for (std::size_t size = 0; size < file.size(); ++size) {
      // A copy of its own, so that the address sanitizer sees a read beyond the end.
      const File cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
      const Decoded decoded = decode_small(cut);
      const bool complete_but_for_padding =
          decoded.fault.empty() && cv::norm(decoded.image, decode_small(file).image) == 0;
      EXPECT_TRUE(decoded.image.empty() || complete_but_for_padding) << size << " bytes";
    }
  }
}

TEST(Hostile, AJpegWithoutItsEndMarkerGivesAFault) {
  File file = encode_jpeg(samples::gradient(kWidth, kHeight), 80);
  file.resize(file.size() - 2);
  EXPECT_THAT(decode_small(file).fault, HasSubstr("damaged JPEG"));
}

TEST(Hostile, NoSingleBitFlipCrashesOrChangesTheSize) {
  for (const File& file : one_of_each()) {
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
      File flipped = file;
      flipped[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
      const Decoded decoded = decode_small(flipped);
      if (decoded.fault.empty()) {
        EXPECT_EQ(decoded.image.size(), cv::Size(kWidth, kHeight)) << "bit " << bit;
      } else {
        EXPECT_TRUE(decoded.image.empty()) << "bit " << bit;
      }
    }
  }
}

TEST(Hostile, NoSingleBitFlipOfAPngGoesUnnoticedInItsPixels) {
  const cv::Mat image = samples::gradient(kWidth, kHeight);
  const File file = encode_png(image);
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    File flipped = file;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    const Decoded decoded = decode_small(flipped);
    EXPECT_TRUE(!decoded.fault.empty() || cv::norm(decoded.image, image) == 0) << "bit " << bit;
  }
}

long peak_kilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

File forged_jpeg(int width, int height) {
  File file = encode_jpeg(samples::gradient(16, 8), 80);
  const std::size_t frame = samples::find_marker(file, 0xc0);
  file[frame + 5] = static_cast<std::uint8_t>(height >> 8);
  file[frame + 6] = static_cast<std::uint8_t>(height);
  file[frame + 7] = static_cast<std::uint8_t>(width >> 8);
  file[frame + 8] = static_cast<std::uint8_t>(width);
  return file;
}

TEST(Hostile, AForgedSizeIsRefusedWithoutTakingMemory) {
  File png = encode_png(samples::gradient(kWidth, kHeight));
  png[18] = png[22] = 0x4e;  // 20 000 px and more per side
  const File jpeg = forged_jpeg(30000, 30000);
  const long before = peak_kilobytes();
  for (int i = 0; i < 1000; ++i) {
    EXPECT_THAT(decode_small(jpeg).fault, HasSubstr("30000 x 30000"));
    EXPECT_THAT(decode_small(png).fault, HasSubstr("the calibration is for"));
  }
  EXPECT_LT(peak_kilobytes() - before, 1024);
}

TEST(Hostile, AJpegOfTooManyScansIsRefused) {
  const File file = samples::progressive_jpeg(samples::gradient(kWidth, kHeight));
  const std::size_t scan = samples::find_marker(file, 0xda);
  std::size_t end = scan + 2;
  while (!(file[end] == 0xff && file[end + 1] != 0 && file[end + 1] < 0xd0)) ++end;
  const File one(file.begin() + static_cast<std::ptrdiff_t>(scan),
                 file.begin() + static_cast<std::ptrdiff_t>(end));
  File bomb = file;
  for (int i = 0; i < 2000; ++i) {
    bomb.insert(bomb.begin() + static_cast<std::ptrdiff_t>(scan), one.begin(), one.end());
  }
  EXPECT_THAT(decode_small(bomb).fault, HasSubstr("too many scans"));
}

TEST(Hostile, GarbageBehindEverySignatureGivesAFault) {
  cv::RNG random(7);
  const std::vector<File> heads{{0xff, 0xd8, 0xff},
                                {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'},
                                {'I', 'I', 42, 0},
                                {'M', 'M', 0, 42}};
  for (const File& head : heads) {
    for (int i = 0; i < 5000; ++i) {
      File file = head;
      file.resize(head.size() + static_cast<std::size_t>(random.uniform(0, 400)));
      for (std::size_t at = head.size(); at < file.size(); ++at) {
        file[at] = static_cast<std::uint8_t>(random.uniform(0, 256));
      }
      EXPECT_NE(decode_small(file).fault, "");
    }
  }
}

}  // namespace
}  // namespace nadir::image_io
