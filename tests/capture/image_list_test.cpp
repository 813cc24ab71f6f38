// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> left_names(const ImageList& list) {
  std::vector<std::string> names;
  for (const ImageFiles& files : list.images) names.push_back(files.left);
  return names;
}

TEST(NaturalOrder, ComparesDigitRunsAsNumbers) {
  // Printed by Python: sorted(names, key=lambda f: [int(t) if t.isdigit() else t
  //                                                 for t in re.split(r'(\d+)', f)])
  const std::vector<std::string> expected{"1.jpg",
                                          "2.jpg",
                                          "10.jpg",
                                          "99999999999999999999998.jpg",
                                          "99999999999999999999999.jpg",
                                          "-9.jpg",
                                          "IMG_2.jpg",
                                          "IMG_10.jpg",
                                          "a.jpg.png",
                                          "b1.jpg",
                                          "b1a.jpg",
                                          "b1b2.jpg",
                                          "b1b10.jpg",
                                          "b.jpg",
                                          "\xc3\xa9.jpg"};
  std::vector<std::string> names = expected;
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(names.begin(), names.end(), random);
    std::sort(names.begin(), names.end(), natural_less);
    ASSERT_EQ(names, expected);
  }
}

TEST(NaturalOrder, IsAStrictOrderAlsoForLeadingZeros) {
  EXPECT_TRUE(natural_less("01", "1"));
  EXPECT_FALSE(natural_less("1", "01"));
  EXPECT_FALSE(natural_less("7a", "7a"));
  EXPECT_TRUE(natural_less("", "0"));
}

TEST(ImageList, FindsImagesInTheImagesFolderOrInTheFolderItself) {
  const SurveyFolder folder;
  folder.write("10.PNG", "");
  folder.write("9.tiff", "");
  folder.write("notes.txt", "");
  folder.write(".hidden.jpg", "");
  std::filesystem::create_directory(folder.root() / "folder.jpg");
  EXPECT_THAT(left_names(list_images(folder.root())), ElementsAre("9.tiff", "10.PNG"));
  folder.write("images/a.jpeg", "");
  EXPECT_THAT(left_names(list_images(folder.root())), ElementsAre("a.jpeg"));
}

TEST(ImageList, MatchesPairsByNameWithoutExtension) {
  const SurveyFolder folder;
  for (const char* name :
       {"left/1.jpg", "left/2.jpg", "left/10.jpg", "right/1.png", "right/10.jpg", "right/3.jpg"}) {
    folder.write(std::string("images/") + name, "");
  }
  const ImageList list = list_images(folder.root());
  EXPECT_TRUE(list.is_stereo());
  ASSERT_EQ(list.images.size(), 4u);
  EXPECT_EQ(list.images[0].right, "1.png");
  EXPECT_EQ(list.images[1].right, "");
  EXPECT_EQ(list.images[2].left, "");
  EXPECT_EQ(list.stem(2), "3");
  EXPECT_EQ(list.images[3].right, "10.jpg");
}

TEST(ImageList, RefusesAFolderWithoutImages) {
  const SurveyFolder folder;
  EXPECT_THROW(list_images(folder.root()), InputError);
  EXPECT_THROW(list_images(folder.root() / "absent"), InputError);
  EXPECT_THROW(list_images(folder.root() / "calib.yml"), InputError);
}

TEST(ImageList, KeepsOddNamesAndOddFiles) {
  const SurveyFolder folder;
  const std::string long_name = std::string(251, 'x') + ".jpg";
  folder.write("images/-n.jpg", "");
  folder.write("images/a\nb.jpg", "");
  folder.write("images/" + long_name, "");
  ASSERT_EQ(::mkfifo((folder.root() / "images/pipe.jpg").c_str(), 0600), 0);
  EXPECT_THAT(left_names(list_images(folder.root())),
              ElementsAre("-n.jpg", "a\nb.jpg", "pipe.jpg", long_name));
}

TEST(ImageList, ListsAHundredThousandNamesQuickly) {
  // The names alone: making the files takes longer than what is measured.
  std::vector<std::string> names;
  for (int i = 0; i < 100'000; ++i) names.push_back("dive_" + std::to_string(i) + ".jpg");
  std::vector<std::string> shuffled = names;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
  std::sort(shuffled.begin(), shuffled.end(), natural_less);
  EXPECT_EQ(shuffled, names);
}

}  // namespace
}  // namespace nadir::capture
