// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/calibration/rig_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "nadir/core/check.hpp"
#include "temporary_file.hpp"

namespace nadir::calibration {
namespace {

using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

// As cv::FileStorage wrote it.
constexpr const char* kMono = R"(%YAML:1.0
---
image_width: 968
image_height: 728
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 7.5710000000000002e+02, 0., 4.8089999999999998e+02, 0.,
       7.5660000000000002e+02, 3.6630000000000001e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 1.1899999999999999e-01, 3.5999999999999997e-02,
       5.0000000000000001e-04, -6.9999999999999999e-04,
       3.0000000000000001e-03 ]
)";

const std::string kPair = std::string(kMono) + R"(camera_matrix_right: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 760., 0., 482., 0., 760., 364., 0., 0., 1. ]
distortion_coefficients_right: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0.1, 0., 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.99980, 0., 0.02000, 0., 1., 0., -0.02000, 0., 0.99980 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.12, 0.001, 0.002 ]
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  return at == text.npos ? text : text.replace(at, what.size(), with);
}

CameraRig load(const std::string& content) { return load_rig(TemporaryFile(content).path()); }

std::string refusal(const std::string& content) {
  try {
    (void)load(content);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RigFile, ReadsOneCamera) {
  const CameraRig rig = load(kMono);
  EXPECT_EQ(rig.left.width, 968);
  EXPECT_EQ(rig.left.height, 728);
  EXPECT_DOUBLE_EQ(rig.left.fx, 757.1);
  EXPECT_DOUBLE_EQ(rig.left.fy, 756.6);
  EXPECT_DOUBLE_EQ(rig.left.cx, 480.9);
  EXPECT_DOUBLE_EQ(rig.left.cy, 366.3);
  EXPECT_EQ(rig.left.lens, LensModel::brown_conrady);
  EXPECT_EQ(rig.left.distortion, (std::array<double, 8>{0.119, 0.036, 5e-4, -7e-4, 3e-3}));
  EXPECT_FALSE(rig.right);
}

TEST(RigFile, ReadsAPair) {
  const CameraRig rig = load(kPair);
  ASSERT_TRUE(rig.right);
  EXPECT_DOUBLE_EQ(rig.right->camera.fx, 760);
  EXPECT_EQ(rig.right->camera.width, 968);
  EXPECT_NEAR(rig.right->right_from_left.translation.x(), -0.12, 1e-12);
  EXPECT_NEAR(rig.right->right_from_left.rotation.norm(), 1, 1e-12);
  const Eigen::Vector3d z = rig.right->right_from_left.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(z.x(), 0.02, 1e-4);  // R above is rounded
}

TEST(RigFile, ReadsXmlAsYaml) {
  const CameraRig rig = load(R"(<?xml version="1.0"?>
<!-- by hand -->
<opencv_storage>
<image_width>968</image_width> <image_height>728</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows> <cols>3</cols> <dt>d</dt>
  <data> 757.1 0. 480.9 0. 756.6 366.3 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>1</rows><cols>4</cols><dt>d</dt>
  <data>0.119 0.036 5e-4 -7e-4</data></distortion_coefficients>
<nested><rows><rows/></rows></nested>
</opencv_storage>)");
  EXPECT_DOUBLE_EQ(rig.left.fx, 757.1);
  EXPECT_DOUBLE_EQ(rig.left.distortion[3], -7e-4);
}

TEST(RigFile, ReadsWhatRosWrites) {
  const CameraRig rig = load(R"(image_width: 752
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [656.911402, 0.000000, 373.735385, 0.000000, 719.001469, 156.944858, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.360085, 0.115116, 0.007768, 0.004616, 0.000000]
)");
  EXPECT_DOUBLE_EQ(rig.left.fy, 719.001469);
}

TEST(RigFile, ReadsAFisheyeCamera) {
  const std::string text(kMono);
  const std::string fisheye = text.substr(0, text.find("distortion")) +
                              R"(distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ 0.01, 0.02, 0.03, 0.04 ]
)";
  const CameraRig rig = load(fisheye + "distortion_model: kannala_brandt\n");
  EXPECT_EQ(rig.left.lens, LensModel::kannala_brandt);
  EXPECT_EQ(rig.left.distortion, (std::array<double, 8>{0.01, 0.02, 0.03, 0.04}));
  EXPECT_THAT(refusal(text + "distortion_model: kannala_brandt\n"), HasSubstr("k1 k2 k3 k4"));
}

TEST(RigFile, IgnoresOtherKeysCommentsBomAndCarriageReturns) {
  std::string text = std::string("\xef\xbb\xbf") + kMono +
                     "# a comment: with a colon\ncalibration_time: \"Mon # 3: x\"\n"
                     "cameras:\n- {a: [1, 2],\n   b: 3}\nempty:\n";
  for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += 2) {
    text.replace(at, 1, "\r\n");
  }
  EXPECT_DOUBLE_EQ(load(text).left.fx, 757.1);
}

TEST(RigFile, NamesFileLineKeyAndRemedy) {
  EXPECT_THAT(refusal(replaced(kMono, "7.5710000000000002e+02", "-1")),
              AllOf(HasSubstr(".yml:5: camera_matrix: "), HasSubstr("must be positive; ")));
}

TEST(RigFile, RefusesWhatIsMissing) {
  EXPECT_THAT(refusal(replaced(kMono, "image_width", "width")),
              AllOf(HasSubstr("image_width is missing"), HasSubstr("found: width, image_height")));
  EXPECT_THAT(refusal(replaced(kPair, "T: !!", "t: !!")), HasSubstr("T is missing"));
  EXPECT_THAT(refusal(replaced(kPair, "camera_matrix_right", "other")),
              HasSubstr("camera_matrix_right is missing"));
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
  EXPECT_THAT(refusal("%YAML:1.0\n---\n"), HasSubstr("missing"));
  EXPECT_THROW(load_rig("/nonexistent/calib.yml"), InputError);
  EXPECT_THROW(load_rig(std::filesystem::temp_directory_path()), InputError);
  EXPECT_THROW(load_rig("/dev/zero"), InputError);
}

TEST(RigFile, RefusesNumbersThatAreNone) {
  for (const char* bad : {".Nan", ".Inf", "nan", "inf", "-1e999", "7x", "0x10", "[1]", "\"7\""}) {
    EXPECT_THAT(refusal(replaced(kMono, "7.5710000000000002e+02", bad)),
                HasSubstr("not a finite number"))
        << bad;
  }
  EXPECT_THAT(refusal(replaced(kMono, "968", "968.5")), HasSubstr("whole number"));
  EXPECT_THAT(refusal(replaced(kMono, "968", "!!binary eHg=")), HasSubstr("not a finite number"));
}

TEST(RigFile, RefusesMatricesOfTheWrongShape) {
  EXPECT_THAT(refusal(replaced(kMono, "rows: 3", "rows: 100000000")), HasSubstr("impossible size"));
  EXPECT_THAT(refusal(replaced(kMono, "rows: 3", "rows: 4")), HasSubstr("9 values for 4 x 3"));
  EXPECT_THAT(refusal(replaced(kMono, "cols: 5", "cols: 1")), HasSubstr("5 values for 1 x 1"));
  EXPECT_THAT(refusal(replaced(kMono, "   dt: d\n   data: [ 7.57", "   dt: d\n   dat: [ 7.57")),
              HasSubstr("has no data"));
  EXPECT_THAT(refusal(std::string(kMono) + "image_width: 968\n"), HasSubstr("given twice"));
}

TEST(RigFile, RefusesCamerasThatCannotBe) {
  EXPECT_THAT(refusal(replaced(kMono, "968", "400")), HasSubstr("principal point"));
  EXPECT_THAT(refusal(replaced(kMono, "968", "2")), HasSubstr("no image size"));
  EXPECT_THAT(refusal(replaced(kMono, "7.5660000000000002e+02", "75.6")),
              HasSubstr("differ too much"));
  const std::string narrow = replaced(replaced(kMono, "7.5710000000000002e+02", "12572"),
                                      "7.5660000000000002e+02", "9842");
  EXPECT_THAT(refusal(narrow), HasSubstr("field of view"));
  EXPECT_THAT(refusal(replaced(kMono, "3.5999999999999997e-02", "-256")),
              HasSubstr("has no inverse"));
  EXPECT_THAT(refusal(std::string(kMono) + "distortion_model: division\n"),
              HasSubstr("distortion_model"));
}

TEST(RigFile, RefusesPairsThatCannotBe) {
  EXPECT_THAT(refusal(replaced(kPair, "-0.12, 0.001, 0.002", "0, 0, 0")), HasSubstr("baseline"));
  EXPECT_THAT(refusal(replaced(kPair, "-0.12, 0.001, 0.002", "-120, 1, 2")), HasSubstr("metres"));
  EXPECT_THAT(refusal(replaced(kPair, "-0.12, 0.001", "0.12, 0.001")),
              HasSubstr("left of the left"));
  EXPECT_THAT(refusal(replaced(kPair, "0.99980, 0., 0.02000", "0.97, 0., 0.02000")),
              HasSubstr("not a rotation"));
  EXPECT_THAT(refusal(replaced(kPair, "0., 1., 0.,", "0., -1., 0.,")), HasSubstr("not a rotation"));
  EXPECT_THAT(refusal(replaced(kPair, "0.99980, 0., 0.02000, 0., 1., 0., -0.02000, 0., 0.99980",
                               "-1, 0, 0, 0, 1, 0, 0, 0, -1")),
              HasSubstr("degrees apart"));
}

TEST(RigFile, RefusesHugeDeepAndForeignFiles) {
  EXPECT_THAT(refusal(std::string(10'000'000, ' ')), HasSubstr("larger than 1 MB"));
  const std::string deep(400'000, '[');
  EXPECT_NE(refusal("%YAML:1.0\n---\na: " + deep + "\n"), "accepted");
  std::string nested = "<opencv_storage>";
  for (int i = 0; i < 100'000; ++i) nested += "<a>";
  EXPECT_THAT(refusal(nested), HasSubstr("tags mismatch"));
  EXPECT_THAT(refusal(std::string("a\0b: 1", 6)), HasSubstr("not a text file"));
  EXPECT_THAT(refusal("{\"fx\": 1}"), HasSubstr("JSON"));
  EXPECT_THAT(refusal("<document><a/></document>"), HasSubstr("not written by OpenCV"));
  EXPECT_THAT(refusal("just some words\n"), HasSubstr("key: value"));
}

TEST(RigFile, SurvivesDamageOfAnyKind) {
  std::mt19937 random(5);
  const auto at = [&](std::size_t size) { return static_cast<std::size_t>(random()) % size; };
  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text = kPair;
    for (std::size_t k = 0; k <= at(4); ++k) {
      switch (at(4)) {
        case 0:
          text[at(text.size())] = static_cast<char>(random());
          break;
        case 1:
          text[at(text.size())] = "[]{}:-,!&*\"'\n <>/?="[at(19)];
          break;
        case 2:
          text.erase(at(text.size()), at(20));
          break;
        default:
          text.resize(1 + at(text.size()));
      }
      if (text.empty()) text.push_back(' ');
    }
    accepted += refusal(text) == "accepted" ? 1 : 0;
  }
  EXPECT_GT(accepted, 0);  // damage to digits cannot always be seen
}

TEST(RigFile, ReadsTheCalibrationOfEverySequence) {
  const std::filesystem::path data(NADIR_SHARED_DATA);
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "not run: no data";
  int count = 0;
  for (const char* group : {"rendered", "real"}) {
    for (const auto& folder : std::filesystem::directory_iterator(data / group)) {
      const auto file = folder.path() / "calib.yml";
      if (!std::filesystem::exists(file)) continue;
      EXPECT_NO_THROW(load_rig(file)) << file;
      ++count;
    }
  }
  EXPECT_GE(count, 17);
}

}  // namespace
}  // namespace nadir::calibration
