// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/pose_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

using ::testing::AllOf, ::testing::ElementsAre, ::testing::HasSubstr;

class PoseFiles : public ::testing::Test {
 protected:
  static std::vector<ListedImage> images(const std::vector<double>& seconds) {
    std::vector<ListedImage> list;
    for (const double s : seconds) {
      std::string name = "00000" + std::to_string(list.size());
      list.push_back({std::move(name), from_seconds(s)});
    }
    return list;
  }
  GivenPoses tum(const std::string& text, const std::vector<ListedImage>& list) const {
    folder_.write("t.tum", text);
    return read_tum(folder_.root() / "t.tum", list);
  }
  GivenPoses colmap(const std::string& text) const {
    folder_.write("model/images.txt", text);
    return read_colmap_poses(folder_.root() / "model", images({0, 1, 2}));
  }
  template <class Read>
  static std::string refusal(Read read) {
    try {
      (void)read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  std::string tum_refusal(const std::string& text) const {
    return refusal([&] { return tum(text, images({0, 1})); });
  }
  std::string colmap_refusal(const std::string& text) const {
    return refusal([&] { return colmap(text); });
  }

  SurveyFolder folder_;
};

std::vector<bool> known(const GivenPoses& given) {
  std::vector<bool> result;
  for (const auto& pose : given.map_from_camera) result.push_back(pose.has_value());
  return result;
}

// A camera that looks down with its x axis to the east: half a turn about x.
constexpr const char* kDown =
    "# seconds tx ty tz qx qy qz qw: survey_from_camera, metres\r\n"
    "0.0 1 2 3 1 0 0 0\r\n"
    "\r\n"
    "2.001 4 5 6 1 0 0 0\r\n"
    "1 -7.5e0 +8 9 1 0 0 0";

TEST_F(PoseFiles, TumPosesGoToTheImagesOfTheirTimes) {
  const GivenPoses given = tum(kDown, images({0, 1.004, 2, 3}));
  EXPECT_THAT(known(given), ElementsAre(true, true, true, false));
  EXPECT_EQ(given.map_from_camera[1]->translation, Eigen::Vector3d(-7.5, 8, 9));
  EXPECT_EQ(given.map_from_camera[2]->translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_LT(
      (*given.map_from_camera[0] * Eigen::Vector3d(1, 1, 1) - Eigen::Vector3d(2, 1, 2)).norm(),
      1e-12);
  EXPECT_TRUE(given.is_survey);
  EXPECT_TRUE(given.is_metric);
}

TEST_F(PoseFiles, ATumPoseIsNeverTakenForTwoImages) {
  std::string text;
  for (int i = 0; i < 10; ++i) text += std::to_string(0.01 * i) + " 0 0 0 1 0 0 0\n";
  EXPECT_THAT(known(tum(text, images({0, 0.0055, 0.1, 0.12}))),
              ElementsAre(true, true, false, false));
  EXPECT_THAT(known(tum(kDown, images({0.019, 0.021}))), ElementsAre(true, false));
}

TEST_F(PoseFiles, ATumFrameWhereCamerasDoNotLookDownIsNotTheSurveys) {
  const GivenPoses given = tum("0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n", images({0, 1}));
  EXPECT_FALSE(given.is_survey);
  EXPECT_TRUE(given.is_metric);
}

TEST_F(PoseFiles, AnUnscaledTrajectoryOfNadirStaysUnscaled) {
  const GivenPoses given =
      tum("# seconds tx ty tz qx qy qz qw: survey_from_camera, unscaled\n0 0 0 0 1 0 0 0\n",
          images({0}));
  EXPECT_TRUE(given.is_survey);
  EXPECT_FALSE(given.is_metric);
}

TEST_F(PoseFiles, MalformedTumFilesAreRefusedWithTheLine) {
  EXPECT_THAT(tum_refusal("# x\n0 1 2 3 1 0 0\n"), AllOf(HasSubstr("t.tum:2: has 7 values")));
  EXPECT_THAT(tum_refusal("0,1,2,3,1,0,0,0\n"), HasSubstr("t.tum:1: has 1 values"));
  EXPECT_THAT(tum_refusal("0 1 2 three 1 0 0 0\n"),
              HasSubstr("t.tum:1: \"three\" is not a number, expected tz"));
  EXPECT_THAT(tum_refusal("0 1 2 nan 1 0 0 0\n"), HasSubstr("t.tum:1: tz is \"nan\""));
  EXPECT_THAT(tum_refusal("0 1 2 3 1 1 0 0\n"), HasSubstr("t.tum:1: the quaternion"));
  EXPECT_THAT(tum_refusal("0 1 2 3 0 0 0 0\n"), HasSubstr("t.tum:1: the quaternion"));
  EXPECT_THAT(tum_refusal("1 1 2 3 1 0 0 0\n0 0 0 0 1 0 0 0\n1 1 2 3 1 0 0 0\n"),
              HasSubstr("t.tum:3: has the same time as line 1"));
  EXPECT_THAT(tum_refusal("9.5e9 1 2 3 1 0 0 0\n"), HasSubstr("t.tum:1: the time"));
  EXPECT_THAT(tum_refusal("# nothing\n"), HasSubstr("t.tum: has no pose"));
  EXPECT_THAT(tum_refusal(""), HasSubstr("t.tum: has no pose"));
  EXPECT_THAT(tum_refusal("50 1 2 3 1 0 0 0\n"), HasSubstr("no pose for any of the images"));
  EXPECT_THAT(refusal([&] { return read_tum(folder_.root() / "none.tum", images({0})); }),
              HasSubstr("there is no such file"));
  EXPECT_THAT(refusal([&] { return read_tum(folder_.root(), images({0})); }),
              HasSubstr("is not a file"));
}

constexpr const char* kModel =
    "# Image list with two lines of data per image:\n"
    "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "7 0 1 0 0 1 2 3 1 left/000002.jpg\n"
    "10.5 20.5 -1 30.5 40.5 12\n"
    "3 1 0 0 0 -1 -2 -3 1 left/000000.jpg\n"
    "\n"
    "4 1 0 0 0 -9 -9 -9 2 right/000000.jpg\n"
    "1.5 2.5 -1\n";

TEST_F(PoseFiles, ColmapPosesGoToTheImagesOfTheirNames) {
  const GivenPoses given = colmap(kModel);
  EXPECT_THAT(known(given), ElementsAre(true, false, true));
  EXPECT_EQ(given.map_from_camera[0]->translation, Eigen::Vector3d(1, 2, 3));
  // camera_from_map turns half about x: the camera is at -R^T t.
  EXPECT_LT((given.map_from_camera[2]->translation - Eigen::Vector3d(-1, 2, 3)).norm(), 1e-12);
  EXPECT_FALSE(given.is_survey || given.is_metric);
}

TEST_F(PoseFiles, ColmapNamesMayLackFolderAndExtensionOrHoldBlanks) {
  EXPECT_THAT(known(colmap("1 1 0 0 0 0 0 0 1 000001\n\n2 1 0 0 0 0 0 0 1 my dive/000002.png\n\n")),
              ElementsAre(false, true, true));
}

TEST_F(PoseFiles, MalformedColmapModelsAreRefusedWithTheLine) {
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 0 0 000001.jpg\n\n"),
              HasSubstr("images.txt:1: has 9 values"));
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 x 0 1 000001.jpg\n\n"),
              HasSubstr("images.txt:1: \"x\" is not a number, expected TY"));
  EXPECT_THAT(colmap_refusal("1 2 0 0 0 0 0 0 1 000001.jpg\n\n"),
              HasSubstr("images.txt:1: the quaternion"));
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 0 0 1 000000.jpg\n2 1 0 0 0 0 0 0 1 000001.jpg\n"),
              HasSubstr("images.txt:2: expected the points"));
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 0 0 1 a b c 0.jpg\n2 1 0 0 0 0 0 0 1 a b 1.jpg\n"),
              HasSubstr("images.txt:2: expected the points"));
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 0 0 1 a/000001.jpg\n\n2 1 0 0 0 0 0 0 1 b/000001.jpg\n"),
              HasSubstr("images.txt:3: is named 000001 as line 1"));
  EXPECT_THAT(colmap_refusal("# nothing\n"), HasSubstr("images.txt: has no image"));
  EXPECT_THAT(colmap_refusal("1 1 0 0 0 0 0 0 1 other.jpg\n\n"), HasSubstr("none of the images"));
}

TEST_F(PoseFiles, WhatIsNoColmapTextModelIsToldHowToBecomeOne) {
  const auto read = [&](const char* name) {
    return refusal([&] { return read_colmap_poses(folder_.root() / name, images({0})); });
  };
  EXPECT_THAT(read("calib.yml"), HasSubstr("is not a folder"));
  folder_.write("binary/images.bin", "\1\2");
  EXPECT_THAT(read("binary"), HasSubstr("model_converter"));
  folder_.write("empty/cameras.txt", "");
  EXPECT_THAT(read("empty"), HasSubstr("images.txt: there is no such file"));
}

}  // namespace
}  // namespace nadir::capture
