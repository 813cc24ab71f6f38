// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_times.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

using ::testing::ElementsAre, ::testing::HasSubstr;

// A JPEG is recognised by its first bytes only here: EXIF is read without decoding.
std::string jpeg_taken(const std::string& date_time) {
  using namespace std::string_literals;
  const std::string exif =
      "Exif\0\0II*\0\x08\0\0\0\x01\0\x69\x87\x04\0\x01\0\0\0\x1a\0\0\0\0\0\0\0"
      "\x01\0\x03\x90\x02\0\x14\0\0\0\x2c\0\0\0\0\0\0\0"s +
      date_time + '\0';
  return "\xff\xd8\xff\xe1"s + '\0' + static_cast<char>(exif.size() + 2) + exif;
}

class ImageTimes : public ::testing::Test {
 protected:
  std::vector<Time> kept_ms() const {
    std::vector<Time> result;
    for (const ImageTime& time : all()) {
      if (time.fault.empty()) result.push_back(time.time / 1'000'000);
    }
    return result;
  }
  std::vector<ImageTime> all() const {
    return image_times(folder_.root(), list_images(folder_.root()));
  }
  void timestamps(const std::string& rows) {
    folder_.write("timestamps.csv", "frame,seconds\n" + rows);
  }
  std::string refusal() const {
    try {
      (void)all();
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  SurveyFolder folder_;
};

TEST_F(ImageTimes, CountSecondsWhenNothingIsKnown) {
  folder_.images(3);
  EXPECT_THAT(kept_ms(), ElementsAre(0, 1000, 2000));
}

TEST_F(ImageTimes, ComeFromTheTableByNameWithoutExtension) {
  folder_.images(3);
  timestamps("2,7.5\n1,6\n0,5.25\nother,9\n");
  EXPECT_THAT(kept_ms(), ElementsAre(5250, 6000, 7500));
  timestamps("0.png,1\n1.png,2\n2.png,3\n");
  EXPECT_THAT(kept_ms(), ElementsAre(1000, 2000, 3000));
}

TEST_F(ImageTimes, MissingOrNotFiniteRejectTheImage) {
  folder_.images(4);
  timestamps("1,1\n2,nan\n3,3\n");
  EXPECT_THAT(kept_ms(), ElementsAre(1000, 3000));
  EXPECT_THAT(all()[0].fault, HasSubstr("no time"));
  EXPECT_THAT(all()[2].fault, HasSubstr("no time"));
}

TEST_F(ImageTimes, ThatDoNotIncreaseRejectAsFewImagesAsPossible) {
  folder_.images(6);
  timestamps("0,0\n1,1e6\n2,2\n3,2\n4,1\n5,5\n");
  EXPECT_EQ(kept_ms().size(), 3u);
  EXPECT_EQ(kept_ms().back(), 5000);
  Time last = 0;
  for (const ImageTime& time : all()) {
    EXPECT_GE(time.time, last);
    last = time.time;
  }
  EXPECT_THAT(all()[1].fault, HasSubstr("does not fit the order"));
}

TEST_F(ImageTimes, RefuseATableThatIsMalformedOrOfAnotherFolder) {
  folder_.images(2);
  timestamps("0,0\n0,1\n");
  EXPECT_THAT(refusal(), HasSubstr("timestamps.csv:3: gives 0 twice"));
  timestamps("0,zero\n");
  EXPECT_THAT(refusal(), HasSubstr("timestamps.csv:2:"));
  timestamps("left_0,0\n");
  EXPECT_THAT(refusal(), HasSubstr("none of the images"));
}

TEST_F(ImageTimes, ComeFromExifWhenAllImagesHaveItAndItIncreases) {
  folder_.write("images/0.jpg", jpeg_taken("2020:06:05 13:14:15"));
  folder_.write("images/1.jpg", jpeg_taken("2020:06:05 13:14:17"));
  EXPECT_THAT(kept_ms(), ElementsAre(1591362855'000, 1591362857'000));
  folder_.write("images/2.jpg", jpeg_taken("2020:06:05 13:14:17"));
  EXPECT_THAT(kept_ms(), ElementsAre(0, 1000, 2000));
  folder_.image("images/2.jpg");
  EXPECT_THAT(kept_ms(), ElementsAre(0, 1000, 2000));
}

}  // namespace
}  // namespace nadir::capture
