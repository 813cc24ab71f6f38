// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/calibration_monitor.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "nadir/odometry/visual_odometry.hpp"
#include "odometry/film.hpp"

namespace nadir::odometry {
namespace {

struct Judged {
  std::vector<Alert> before_end, at_end;
  std::size_t key_frames = 0;
  double largest_rms_px = 0;
};

// What the monitor says of the key frames that odometry settles.
Judged judge(const Film& shots) {
  VisualOdometry odometry({}, [](const Window&, const auto&) { return SubmapPlacement{}; });
  CalibrationMonitor monitor;
  Judged result;
  const auto observe = [&](const Orientation& o, bool last) {
    result.key_frames += o.settled.size();
    if (o.window) result.largest_rms_px = std::max(result.largest_rms_px, o.window->rms_px);
    for (const Alert& alert : monitor.observe(o.settled, last)) {
      EXPECT_EQ(alert.kind, AlertKind::calibration_suspect);
      EXPECT_FALSE(alert.remedy.empty()) << alert.message;
      (last ? result.at_end : result.before_end).push_back(alert);
    }
  };
  for (const auto& shot : shots) observe(odometry.process(shot), false);
  observe(odometry.finish(), true);
  return result;
}

void expect_no_alert(const Film& shots) {
  const Judged judged = judge(shots);
  EXPECT_EQ(judged.key_frames, shots.size());
  for (const auto* alerts : {&judged.before_end, &judged.at_end}) {
    for (const Alert& alert : *alerts) ADD_FAILURE() << alert.message;
  }
}

// A film whose calibration says something else than what it was taken with.
Film calibrated_as(const CameraRig& given, const Film& shots) {
  const auto rig = std::make_shared<const CameraRig>(given);
  return with_frames(shots, [&](const Film&, std::size_t, Frame& frame) { frame.rig = rig; });
}

// The films are of a lens without distortion.
CameraRig bent(CameraRig rig, double k1) {
  (rig.right ? rig.right->camera : rig.left).distortion[0] = k1;
  return rig;
}

TEST(CalibrationMonitor, SuspectsNoCalibrationThatFits) {
  for (const CameraRig& rig : {small_rig(), small_pair()}) {
    expect_no_alert(film(rig, swimming_path(16)));
  }
}

// Eight settled key frames decide; odometry settles one six images later.
TEST(CalibrationMonitor, SuspectsTheCalibrationOfAnotherLensOnceInADive) {
  const Film shots = film(small_rig(), swimming_path(16));
  for (const double k1 : {-0.2, 0.2}) {
    const Judged judged = judge(calibrated_as(bent(small_rig(), k1), shots));
    ASSERT_FALSE(judged.before_end.empty()) << k1;
    for (const Alert& alert : judged.before_end) {
      EXPECT_EQ(alert.image, 7U) << k1 << ": " << alert.message;
      EXPECT_EQ(alert.time, from_seconds(7)) << k1;
    }
    EXPECT_TRUE(judged.at_end.empty()) << k1;
  }
}

TEST(CalibrationMonitor, LooksOnceMoreWhenAShortDiveEnds) {
  const Film shots = film(small_rig(), swimming_path(8));
  for (const double k1 : {-0.2, 0.2}) {
    const Judged judged = judge(calibrated_as(bent(small_rig(), k1), shots));
    EXPECT_TRUE(judged.before_end.empty()) << k1;
    ASSERT_FALSE(judged.at_end.empty()) << k1;
    EXPECT_EQ(judged.at_end.front().image, 7U) << k1;
  }
}

TEST(CalibrationMonitor, SuspectsTheCalibrationOfAnotherRightLens) {
  const Film shots = film(small_pair(), swimming_path(10));
  const Judged judged = judge(calibrated_as(bent(small_pair(), 0.15), shots));
  EXPECT_TRUE(std::ranges::any_of(
      judged.at_end, [](const Alert& alert) { return alert.message.starts_with("right camera"); }));
}

// Larger ones than another lens leaves.
TEST(CalibrationMonitor, SuspectsNoCalibrationForTheResidualsOfNoiseAndBlur) {
  const Film good = film(small_rig(), swimming_path(16));
  const Film poor = with_frames(good, [](const Film&, std::size_t i, Frame& frame) {
    cv::Mat noise(frame.grey.size(), CV_16S), blurred;
    cv::RNG random(i + 1);
    random.fill(noise, cv::RNG::NORMAL, 0, 8);
    cv::GaussianBlur(frame.grey, blurred, {}, 1.5);
    cv::add(blurred, noise, frame.grey, cv::noArray(), CV_8U);
  });
  expect_no_alert(poor);
  EXPECT_GT(judge(poor).largest_rms_px,
            judge(calibrated_as(bent(small_rig(), 0.2), good)).largest_rms_px);
}

// A straight strip over flat ground looks the same to a longer lens from higher up.
TEST(CalibrationMonitor, ClaimsNothingOfAFocalLengthThatImagesDoNotShow) {
  std::vector<Rigid3> strip;
  for (int i = 0; i < 16; ++i) strip.push_back(looking_down(0.2 * i, 0, 1));
  CameraRig given = small_rig();
  given.left.fx = given.left.fy = 1.25 * given.left.fx;
  expect_no_alert(calibrated_as(given, film(small_rig(), strip)));
}

// Their frames have nothing to do with each other. The end of the first sub-map is too short.
TEST(CalibrationMonitor, JudgesASubmapByItsOwnKeyFrames) {
  std::vector<Rigid3> path;
  for (const Rigid3& pose : swimming_path(6)) path.push_back(pose);
  for (const Rigid3& pose : swimming_path(9)) {
    path.push_back(Rigid3{Eigen::Quaterniond::Identity(), {2.2, 0.9, 0}} * pose);
  }
  const Judged judged = judge(calibrated_as(bent(small_rig(), 0.2), film(small_rig(), path)));
  EXPECT_TRUE(judged.before_end.empty());
  ASSERT_FALSE(judged.at_end.empty());
  EXPECT_EQ(judged.at_end.front().image, path.size() - 1);
}

TEST(CalibrationMonitor, SaysNothingOfNoKeyFrames) {
  CalibrationMonitor monitor;
  EXPECT_TRUE(monitor.observe({}, false).empty());
  EXPECT_TRUE(monitor.observe({}, true).empty());
  EXPECT_EQ(ResidualVariance().ratio(), 0);
}

}  // namespace
}  // namespace nadir::odometry
