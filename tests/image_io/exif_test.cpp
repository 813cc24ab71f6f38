// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/image_io/exif.hpp"

#include <gtest/gtest.h>

#include "nadir/image_io/encode.hpp"
#include "samples.hpp"

namespace nadir::image_io {
namespace {

using samples::File;

File jpeg_taken(const std::string& date_time, const std::string& sub_second) {
  return samples::with_segment(encode_jpeg(samples::gradient(16, 8), 80), 0xe1,
                               samples::exif(date_time, sub_second));
}

TEST(Exif, GivesTheTimeAPictureWasTaken) {
  // date -u -d '2020-06-05 13:14:15' +%s
  EXPECT_EQ(read_exif_time(jpeg_taken("2020:06:05 13:14:15", "")), 1591362855'000'000'000);
  EXPECT_EQ(read_exif_time(jpeg_taken("2020:06:05 13:14:15", "25")), 1591362855'250'000'000);
}

TEST(Exif, GivesNoTimeWithoutAValidOne) {
  EXPECT_FALSE(read_exif_time(encode_jpeg(samples::gradient(16, 8), 80)));
  EXPECT_FALSE(read_exif_time({}));
  EXPECT_FALSE(read_exif_time(jpeg_taken("0000:00:00 00:00:00", "")));
  EXPECT_FALSE(read_exif_time(jpeg_taken("2020:02:30 00:00:00", "")));
  EXPECT_FALSE(read_exif_time(jpeg_taken("2020:06:05 24:00:00", "")));
  EXPECT_FALSE(read_exif_time(jpeg_taken("    :  :     :  :  ", "")));
  EXPECT_FALSE(read_exif_time(jpeg_taken("2020-06-05 13:14:15", "")));
}

TEST(Exif, SurvivesEveryByteOfItsDirectoriesBeingWrong) {
  const File sample = jpeg_taken("2020:06:05 13:14:15", "25");
  int with_time = 0;
  for (std::size_t at = 2; at < 120; ++at) {
    for (int value = 0; value < 256; ++value) {
      File file = sample;
      file[at] = static_cast<std::uint8_t>(value);
      with_time += read_exif_time(file).has_value() ? 1 : 0;
    }
  }
  EXPECT_GT(with_time, 0);
  for (std::size_t size = 0; size < 130; ++size) {
    (void)read_exif_time(std::span(sample).first(size));
  }
}

TEST(Exif, DoesNotFollowADirectoryThatPointsToItself) {
  File loop = samples::exif("2020:06:05 13:14:15", "");
  // The EXIF directory's offset, value of the second entry of IFD0: 6 + 8 + 2 + 12 + 8.
  loop[36] = 8;
  const File file = samples::with_segment(encode_jpeg(samples::gradient(16, 8), 80), 0xe1, loop);
  EXPECT_FALSE(read_exif_time(file));
}

}  // namespace
}  // namespace nadir::image_io
