// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/folder_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <map>
#include <numbers>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

using ::testing::AllOf, ::testing::HasSubstr;

std::vector<Shot> all_shots(FolderSource source) {
  std::vector<Shot> shots;
  while (auto shot = source.next()) shots.push_back(*std::move(shot));
  EXPECT_FALSE(source.next());
  EXPECT_EQ(shots.size(), source.size());
  return shots;
}

std::vector<Shot> all_shots(const SurveyFolder& folder, Config config = {}) {
  return all_shots(FolderSource(folder.root(), std::nullopt, config));
}

std::vector<Alert> all_alerts(const SurveyFolder& folder) {
  std::vector<Alert> alerts;
  for (const Shot& shot : all_shots(folder)) {
    alerts.insert(alerts.end(), shot.alerts.begin(), shot.alerts.end());
  }
  return alerts;
}

std::string refusal(const std::filesystem::path& folder, Config config = {}) {
  try {
    FolderSource source(folder, std::nullopt, config);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

void expect_rejected(const Shot& shot, const std::string& file, const std::string& why) {
  EXPECT_EQ(shot.frame, nullptr) << file;
  ASSERT_EQ(shot.alerts.size(), 1u) << file;
  EXPECT_EQ(shot.alerts[0].kind, AlertKind::image_rejected);
  EXPECT_EQ(shot.alerts[0].image, shot.image);
  EXPECT_THAT(shot.alerts[0].message, AllOf(HasSubstr(file), HasSubstr(why)));
  EXPECT_NE(shot.alerts[0].remedy, "");
}

TEST(FolderSource, GivesColourAndGreyOfEveryImageInOrder) {
  const SurveyFolder folder;
  for (const int i : {2, 10, 1}) folder.image("images/" + std::to_string(i) + ".png", 10 * i);
  const auto shots = all_shots(folder);
  ASSERT_EQ(shots.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(shots[i].frame);
    EXPECT_EQ(shots[i].image, i);
    EXPECT_EQ(shots[i].frame->image, i);
    EXPECT_EQ(shots[i].time, from_seconds(static_cast<double>(i)));
    EXPECT_EQ(shots[i].frame->time, shots[i].time);
    EXPECT_TRUE(shots[i].alerts.empty());
  }
  const Frame& last = *shots[2].frame;
  EXPECT_EQ(last.name, "10");
  EXPECT_EQ(last.colour.at<cv::Vec3b>(5, 5), cv::Vec3b(100, 120, 140));
  EXPECT_NEAR(last.grey.at<std::uint8_t>(5, 5), 0.114 * 100 + 0.587 * 120 + 0.299 * 140, 1);
  EXPECT_TRUE(last.right.empty());
  EXPECT_FALSE(last.rig->right);
}

TEST(FolderSource, GivesPairs) {
  const SurveyFolder folder;
  folder.write("calib.yml", SurveyFolder::stereo_calibration());
  for (const char* name : {"images/left/7.png", "images/right/7.jpg"}) folder.image(name);
  const FolderSource source(folder.root(), std::nullopt, {});
  EXPECT_TRUE(source.is_stereo());
  const auto shots = all_shots(folder);
  ASSERT_EQ(shots.size(), 1u);
  ASSERT_TRUE(shots[0].frame);
  EXPECT_EQ(shots[0].frame->right.type(), CV_8UC1);
  EXPECT_EQ(shots[0].frame->right.size(), shots[0].frame->grey.size());
  ASSERT_TRUE(shots[0].frame->rig->right);
  EXPECT_EQ(shots[0].frame->rig->right->camera.fx, 41);
}

TEST(FolderSource, TurnsTheCameraAsItIsMounted) {
  const SurveyFolder folder;
  folder.images(1);
  Config config;
  config.mounting_pitch_deg = 30;
  const FolderSource ahead(folder.root(), std::nullopt, config);
  const Eigen::Vector3d axis = ahead.rig()->body_from_camera * Eigen::Vector3d::UnitZ();
  EXPECT_LT((axis - Eigen::Vector3d(0.5, 0, std::sqrt(0.75))).norm(), 1e-12);
  config = {};
  config.mounting_yaw_deg = 90;  // the image's top points to starboard
  const FolderSource turned(folder.root(), std::nullopt, config);
  const Eigen::Vector3d top = turned.rig()->body_from_camera * -Eigen::Vector3d::UnitY();
  EXPECT_LT((top - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  config.mounting_roll_deg = 181;
  EXPECT_THROW(config.check(), InputError);
}

TEST(FolderSource, RejectsAnImageWithoutItsPartner) {
  const SurveyFolder folder;
  folder.write("calib.yml", SurveyFolder::stereo_calibration());
  for (const char* name :
       {"images/left/1.png", "images/right/1.png", "images/left/2.png", "images/right/3.png"}) {
    folder.image(name);
  }
  const auto shots = all_shots(folder);
  ASSERT_EQ(shots.size(), 3u);
  EXPECT_TRUE(shots[0].frame);
  expect_rejected(shots[1], "left/2.png", "has no right image");
  expect_rejected(shots[2], "right/3.png", "has no left image");
}

TEST(FolderSource, UsesTheLeftCameraOfAPairForAMonoFolder) {
  const SurveyFolder folder;
  folder.write("calib.yml", SurveyFolder::stereo_calibration());
  folder.images(1);
  const FolderSource source(folder.root(), std::nullopt, {});
  EXPECT_FALSE(source.is_stereo());
  EXPECT_FALSE(source.rig()->right);
  EXPECT_EQ(source.rig()->left.fx, 40);
}

TEST(FolderSource, TakesABareFolderWithACalibrationFromElsewhere) {
  const SurveyFolder folder;
  folder.image("bare/a.png");
  FolderSource source(folder.root() / "bare", folder.root() / "calib.yml", {});
  EXPECT_EQ(source.size(), 1u);
  EXPECT_TRUE(source.next()->frame);
  EXPECT_THAT(refusal(folder.root() / "bare"), AllOf(HasSubstr("calib.yml"), HasSubstr("--calib")));
}

TEST(FolderSource, ReducesImagesAndCameraAlike) {
  const SurveyFolder folder;
  folder.image("images/a.png");
  folder.image("images/b.jpg");
  for (const auto& [scale, width, height] : {std::tuple{0.5, 25, 19}, std::tuple{0.25, 13, 10}}) {
    for (const Shot& shot : all_shots(folder, {scale})) {
      ASSERT_TRUE(shot.frame);
      EXPECT_EQ(shot.frame->grey.size(), cv::Size(width, height));
      EXPECT_EQ(shot.frame->colour.size(), cv::Size(width, height));
      EXPECT_EQ(shot.frame->rig->left.width, width);
      EXPECT_EQ(shot.frame->rig->left.height, height);
      EXPECT_DOUBLE_EQ(shot.frame->rig->left.fx, 40 * scale);
    }
  }
  EXPECT_THAT(refusal(folder.root(), {0.3}), HasSubstr("capture.scale"));
}

TEST(FolderSource, SkipsWhatIsNotAnImageOfThisCameraAndSaysWhy) {
  const SurveyFolder folder;
  folder.image("images/0.jpg");
  auto cut = image_io::encode_jpeg(
      cv::Mat(SurveyFolder::kHeight, SurveyFolder::kWidth, CV_8UC3, cv::Scalar(40, 90, 70)), 95);
  cut.resize(cut.size() - 30);
  folder.write("images/1.jpg", cut);
  folder.write("images/2.jpg", "");
  folder.write("images/3.jpg", "x");
  folder.image("images/4.jpg", 100, SurveyFolder::kHeight, SurveyFolder::kWidth);
  folder.write("images/5.png", "GIF89a");
  ASSERT_EQ(::mkfifo((folder.root() / "images/6.jpg").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder.root() / "images/7.jpg");
  std::filesystem::create_symlink(folder.root() / "images/0.jpg", folder.root() / "images/8.jpg");
  std::filesystem::create_symlink("nowhere", folder.root() / "images/9.jpg");
  folder.image("images/10.jpg");
  folder.write("images/11.jpg", "");
  std::filesystem::resize_file(folder.root() / "images/11.jpg", std::uint64_t{1} << 36);
  folder.image("images/12\n.jpg");

  const auto shots = all_shots(folder);
  ASSERT_EQ(shots.size(), 13u);
  EXPECT_TRUE(shots[0].frame);
  expect_rejected(shots[1], "1.jpg", "damaged JPEG");
  expect_rejected(shots[2], "2.jpg", "empty file");
  expect_rejected(shots[3], "3.jpg", "not a JPEG");
  expect_rejected(shots[4], "4.jpg", "is 38 x 50 px, the calibration is for 50 x 38 px");
  expect_rejected(shots[5], "5.png", "GIF is not supported");
  expect_rejected(shots[6], "6.jpg", "not a regular file");
  expect_rejected(shots[7], "7.jpg", "symbolic link");
  expect_rejected(shots[8], "8.jpg", "symbolic link");
  expect_rejected(shots[9], "9.jpg", "symbolic link");
  EXPECT_TRUE(shots[10].frame);
  expect_rejected(shots[11], "11.jpg", "too large");
  EXPECT_TRUE(shots[12].frame);
  EXPECT_EQ(shots[12].name, "12?");
}

TEST(FolderSource, SkipsAnUnreadableImage) {
  const SurveyFolder folder;
  folder.images(2);
  std::filesystem::permissions(folder.root() / "images/1.png", std::filesystem::perms::none);
  constexpr uid_t kNobody = 65534;
  const uid_t me = ::geteuid();
  if (me == 0) {
    ASSERT_EQ(::seteuid(kNobody), 0);  // root can read everything
  }
  const auto shots = all_shots(folder);
  ASSERT_EQ(::seteuid(me), 0);
  EXPECT_TRUE(shots[0].frame);
  expect_rejected(shots[1], "1.png", "cannot be opened: Permission denied");
}

TEST(FolderSource, GoesOnWhenImagesVanish) {
  const SurveyFolder folder;
  folder.images(3);
  FolderSource source(folder.root(), std::nullopt, {});
  EXPECT_TRUE(source.next()->frame);
  std::filesystem::remove_all(folder.root());
  expect_rejected(*source.next(), "1.png", "cannot be opened");
  expect_rejected(*source.next(), "2.png", "cannot be opened");
  EXPECT_FALSE(source.next());
}

TEST(FolderSource, StartsWhenTheFirstImagesAreDamaged) {
  const SurveyFolder folder;
  folder.images(3);
  folder.write("images/0.png", "");
  folder.image("images/1.png", 100, 20, 20);
  const auto shots = all_shots(folder);
  EXPECT_FALSE(shots[0].frame);
  EXPECT_FALSE(shots[1].frame);
  EXPECT_TRUE(shots[2].frame);
}

TEST(FolderSource, RefusesImagesOfAnotherCameraNamingBothSizes) {
  const SurveyFolder folder;
  folder.image("images/0.png", 100, 64, 48);
  folder.image("images/1.png", 100, 64, 48);
  EXPECT_THAT(refusal(folder.root()),
              AllOf(HasSubstr("0.png"), HasSubstr("64 x 48"), HasSubstr("50 x 38")));
}

TEST(FolderSource, RefusesAPairOfFoldersWithoutACalibratedPair) {
  const SurveyFolder folder;
  for (const char* name : {"images/left/1.png", "images/right/1.png"}) folder.image(name);
  EXPECT_THAT(refusal(folder.root()), HasSubstr("calibrates one camera"));
  folder.write("calib.yml", SurveyFolder::stereo_calibration());
  std::filesystem::rename(folder.root() / "images/right/1.png",
                          folder.root() / "images/right/2.png");
  EXPECT_THAT(refusal(folder.root()), HasSubstr("no image has a partner"));
}

TEST(FolderSource, RejectsImagesWhoseTimeIsMissingOrRunsBackwards) {
  const SurveyFolder folder;
  folder.images(4);
  folder.write("timestamps.csv", "frame,seconds\n0,10\n1,9\n3,12.5\n");
  const auto shots = all_shots(folder);
  const bool first_kept = shots[0].frame != nullptr;
  EXPECT_NE(first_kept, shots[1].frame != nullptr);
  expect_rejected(shots[first_kept ? 1 : 0], ".png", "does not fit the order");
  expect_rejected(shots[2], "2.png", "no time");
  ASSERT_TRUE(shots[3].frame);
  EXPECT_EQ(shots[3].frame->time, 12'500'000'000);
}

TEST(FolderSource, GivesWhatTheSensorsSaidAtEachImage) {
  const SurveyFolder folder;
  folder.images(3);
  folder.write("ahrs.csv",
               "seconds,roll,pitch,yaw\n0,0,0,0\n0.9,10,-20,170\n1.1,20,-10,-170\n1.3,nan,0,0\n");
  folder.write("depth.csv", "seconds,depth\n0.8,12\n1.2,13\n");
  folder.write("altitude.csv", "seconds,altitude\n2,1.5\n");
  const auto shots = all_shots(folder);
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_TRUE(shots[0].frame->attitude);
  EXPECT_FALSE(shots[0].frame->depth);
  ASSERT_TRUE(shots[1].frame->attitude);
  EXPECT_NEAR(shots[1].frame->attitude->roll, 15 * kDegree, 1e-9);
  EXPECT_NEAR(shots[1].frame->attitude->pitch, -15 * kDegree, 1e-9);
  EXPECT_NEAR(std::abs(shots[1].frame->attitude->yaw), 180 * kDegree, 1e-9);
  EXPECT_NEAR(shots[1].frame->depth.value(), 12.5, 1e-9);
  EXPECT_FALSE(shots[1].frame->altitude);
  EXPECT_FALSE(shots[2].frame->attitude);
  EXPECT_EQ(shots[2].frame->altitude, 1.5);

  ASSERT_EQ(shots[0].alerts.size(), 1u);
  EXPECT_EQ(shots[0].alerts[0].kind, AlertKind::sensor_stale);
  EXPECT_THAT(shots[0].alerts[0].message, AllOf(HasSubstr("ahrs.csv"), HasSubstr("1 row")));
}

TEST(FolderSource, TellsOnceOfASensorWhoseClockIsNotTheImages) {
  const SurveyFolder folder;
  folder.images(12);
  folder.write("ahrs.csv", "seconds,roll,pitch,yaw\n-3600,0,0,0\n-3583.2,1,2,3\n");
  const auto alerts = all_alerts(folder);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::sensor_stale);
  EXPECT_EQ(alerts[0].image, 9u);
  EXPECT_EQ(alerts[0].message,
            "ahrs.csv says nothing of images 0 to 9 (0.0 to 9.0 s); its 2 rows are of -3600.0 to "
            "-3583.2 s");
  EXPECT_THAT(alerts[0].remedy, AllOf(HasSubstr("clock"), HasSubstr("timestamps.csv")));
}

TEST(FolderSource, TellsAtTheEndOfAFewImagesWithoutAnyValue) {
  const SurveyFolder folder;
  folder.images(3);
  folder.write("depth.csv", "seconds,depth\n50,3\n");
  const auto alerts = all_alerts(folder);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].image, 2u);
  EXPECT_THAT(alerts[0].message, HasSubstr("depth.csv says nothing of images 0 to 2"));
}

TEST(FolderSource, TellsAtTheEndOfASensorWithoutAnyValueThoughTheLastImageIsRejected) {
  const SurveyFolder folder;
  folder.images(3);
  folder.write("images/3.png", "no picture");
  folder.write("depth.csv", "seconds,depth\n50,3\n");
  const auto alerts = all_alerts(folder);
  ASSERT_EQ(alerts.size(), 2u);
  EXPECT_EQ(alerts[0].kind, AlertKind::image_rejected);
  EXPECT_EQ(alerts[1].kind, AlertKind::sensor_stale);
  EXPECT_THAT(alerts[1].message, HasSubstr("depth.csv says nothing of images 0 to 2"));
}

TEST(FolderSource, TellsOfASensorThatStoppedAndAgainOnlyOfALongerGap) {
  const SurveyFolder folder;
  folder.images(80);
  std::string log = "seconds,altitude\n";
  const auto is_silent = [](int s) {
    return (s > 5 && s < 18) || (s > 20 && s < 33) || (s > 40 && s < 75);
  };
  for (int s = 0; s < 80; ++s) {
    if (!is_silent(s)) log += std::to_string(s) + ",2.5\n";
  }
  folder.write("altitude.csv", log);
  const auto alerts = all_alerts(folder);
  ASSERT_EQ(alerts.size(), 2u);
  EXPECT_EQ(alerts[0].image, 15u);
  EXPECT_THAT(alerts[0].message, HasSubstr("images 6 to 15 (6.0 to 15.0 s), the last it told of "
                                           "was at 5.0 s"));
  EXPECT_EQ(alerts[1].image, 60u);
}

TEST(FolderSource, ShortGapsOfASensorAreNotWorthAnAlert) {
  const SurveyFolder folder;
  folder.images(40);
  std::string times = "frame,seconds\n";  // a film of 10 Hz whose sensor begins after 3 s
  for (int i = 0; i < 40; ++i) times += std::to_string(i) + "," + std::to_string(0.1 * i) + "\n";
  folder.write("timestamps.csv", times);
  folder.write("depth.csv", "seconds,depth\n3,3\n3.5,3\n4,3\n");
  EXPECT_TRUE(all_alerts(folder).empty());
}

TEST(FolderSource, TellsOfASensorFileWithoutAUsableRow) {
  const SurveyFolder folder;
  folder.images(1);
  folder.write("depth.csv", "seconds,depth\n");
  folder.write("altitude.csv", "seconds,altitude\n0,-2\n1,-2\n");
  const auto alerts = all_alerts(folder);
  ASSERT_EQ(alerts.size(), 2u);
  EXPECT_EQ(alerts[0].message, "depth.csv: holds no row");
  EXPECT_THAT(alerts[1].message, HasSubstr("altitude.csv: all 2 rows were dropped"));
}

TEST(FolderSource, RefusesAMalformedSensorFile) {
  const SurveyFolder folder;
  folder.images(1);
  folder.write("depth.csv", "seconds,depth\n0,shallow\n");
  EXPECT_THAT(refusal(folder.root()), HasSubstr("depth.csv:2:"));
}

TEST(FolderSource, KnowsTheLasers) {
  const SurveyFolder folder;
  folder.images(1);
  EXPECT_FALSE(FolderSource(folder.root(), std::nullopt, {}).lasers());
  folder.write("lasers.yml", "separation_m: 0.1\n");
  const FolderSource source(folder.root(), std::nullopt, {});
  ASSERT_TRUE(source.lasers());
  EXPECT_EQ(source.lasers()->separation, 0.1);
}

struct Expected {
  std::size_t images;
  bool stereo, attitude, lasers;
  double second_time;  ///< of image 1
  const char* second_name;
};

TEST(FolderSource, ReadsTheSharedSequences) {
  const std::filesystem::path data(NADIR_SHARED_DATA);
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "not run: no data";
  const std::map<std::string, Expected> sequences{
      {"rendered/pool", {81, true, true, false, 2.0016, "000001"}},
      {"rendered/transect", {160, false, true, true, 0.4921, "000001"}},
      {"rendered/reef", {100, false, true, false, 2.01, "000001"}},
      {"rendered/wreck", {40, true, true, false, 0.498, "000001"}},
      {"real/amphora-20fps", {80, false, false, false, 0.05, "0001"}},
      {"real/beach-aerial", {41, false, false, false, 1, "IMG_0025"}},
      {"real/cave-sparus", {22, false, false, false, 0.2, "0001"}},
      {"real/open-water", {10, false, false, false, 1, "001"}},
      {"real/seabed-strip-9", {8, false, false, false, 1, "002"}},
      {"real/wreck-jason", {122, false, false, false, 13, "0540"}},
  };
  for (const auto& [name, expected] : sequences) {
    FolderSource source(data / name, std::nullopt, {0.25});
    EXPECT_EQ(source.size(), expected.images) << name;
    EXPECT_EQ(source.is_stereo(), expected.stereo) << name;
    EXPECT_EQ(source.lasers().has_value(), expected.lasers) << name;
    for (int i = 0; i < 2; ++i) {
      const auto shot = source.next();
      ASSERT_TRUE(shot && shot->frame) << name << ": " << shot->alerts[0].message;
      EXPECT_EQ(shot->frame->right.empty(), !expected.stereo) << name;
      EXPECT_EQ(shot->frame->attitude.has_value(), expected.attitude) << name;
      EXPECT_EQ(shot->time, i == 0 ? 0 : from_seconds(expected.second_time)) << name;
      EXPECT_TRUE(i == 0 || shot->name == expected.second_name) << name;
    }
  }
}

}  // namespace
}  // namespace nadir::capture
