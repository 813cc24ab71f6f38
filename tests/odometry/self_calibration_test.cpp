// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/self_calibration.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using ::testing::AllOf, ::testing::Contains, ::testing::Field, ::testing::HasSubstr,
    ::testing::IsEmpty;

constexpr double kNoise_px = 0.1;
constexpr int kImages = 16;

CameraRig mono() {
  CameraRig rig = small_rig();
  rig.left.distortion = {-0.11, 0.09, -5e-4, 6e-4, -0.05};
  return rig;
}

CameraRig pair() {
  CameraRig rig = mono();
  rig.right = CameraRig::Right{rig.left, small_pair().right->right_from_left};
  rig.right->camera.fx = rig.right->camera.fy = 303;
  return rig;
}

// A swim over relief, with roll, pitch and changes of altitude that neighbouring images sample
// well.
Rigid3 pose_at(double i) {
  const Eigen::Quaterniond sway(Eigen::AngleAxisd(0.12 * std::sin(0.5 * i), Vector3d::UnitX()) *
                                Eigen::AngleAxisd(0.12 * std::cos(0.4 * i), Vector3d::UnitY()));
  Rigid3 pose = looking_down(0.15 * i, 0.1 * std::sin(0.5 * i), 1 + 0.1 * std::sin(0.7 * i));
  pose.rotation = pose.rotation * sway;
  return pose;
}

// What odometry with `given` settles of images taken with `truth`, the right ones `delay` images
// later.
std::vector<std::shared_ptr<const SettledKeyFrame>> survey(const CameraRig& truth,
                                                           const CameraRig& given,
                                                           double delay = 0) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal(0, kNoise_px);
  std::vector<Vector3d> points;
  for (int k = 0; k < 1500; ++k) {
    points.emplace_back(1.2 + 2 * uniform(random), 0.9 * uniform(random), 0.15 * uniform(random));
  }
  const auto seen = [&](const CameraModel& camera, const CameraModel& assumed,
                        const Vector3d& x) -> std::optional<Vector2d> {
    const auto pixel = camera.project(x);
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > camera.width - 1 ||
        pixel->y() > camera.height - 1) {
      return std::nullopt;
    }
    return assumed.unproject(*pixel + Vector2d(normal(random), normal(random)));
  };
  const auto rig = std::make_shared<const CameraRig>(given);
  std::vector<std::shared_ptr<const SettledKeyFrame>> all;
  for (int i = 0; i < kImages; ++i) {
    auto key_frame = std::make_shared<SettledKeyFrame>();
    key_frame->rig = rig;
    key_frame->pose.image = static_cast<std::uint64_t>(i);
    key_frame->pose.time = from_seconds(i);
    key_frame->pose.survey_from_camera = pose_at(i);
    const Rigid3 left = pose_at(i).inverse(), late = pose_at(i + delay).inverse();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto ray = seen(truth.left, given.left, left * points[k]);
      if (!ray) continue;
      TiePointObservation observation{k, *ray, {}, points[k]};
      if (truth.right) {
        observation.right_ray = seen(truth.right->camera, given.right->camera,
                                     truth.right->right_from_left * (late * points[k]));
      }
      key_frame->observations.push_back(observation);
    }
    all.push_back(std::move(key_frame));
  }
  return all;
}

auto doubt(AlertKind kind, const char* message) {
  return Contains(AllOf(Field(&Alert::kind, kind), Field(&Alert::message, HasSubstr(message))));
}

TEST(SelfCalibration, TrueCalibrationIsNotDoubtedAndItsResidualsAreTheNoise) {
  for (const CameraRig& rig : {mono(), pair()}) {
    const auto fit = fit_calibration(survey(rig, rig));
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->images, kImages);
    EXPECT_THAT(doubts(*fit), IsEmpty());
    EXPECT_NEAR(fit->rms_px, kNoise_px * std::sqrt(2.0), 0.03);
    EXPECT_NEAR(fit->left.focal_ratio.value, 1, 4 * fit->left.focal_ratio.sigma);
    EXPECT_LT(fit->left.focal_ratio.sigma, 0.005);
    EXPECT_LT(fit->left.distortion_px.value, 4 * fit->left.distortion_px.sigma);
    if (fit->pair) {
      EXPECT_NEAR(fit->pair->delay_s.value, 0, 4 * fit->pair->delay_s.sigma);
    }
  }
}

TEST(SelfCalibration, MissingCoefficientIsToldByHowFarItMovesTheCorners) {
  CameraRig given = pair();
  given.left.distortion[4] = 0;
  given.right->camera.distortion[4] = 0;
  // -0.05 r^7 of 300 px; less what a zoom takes up.
  const double corner = std::hypot(159.5, 119.5) / 300;
  const double most = 0.05 * std::pow(corner, 7) * 300;
  const auto fit = fit_calibration(survey(pair(), given));
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->left.distortion_px.value, 3 * fit->left.distortion_px.sigma);
  EXPECT_LT(fit->left.distortion_px.value, 1.2 * most);
}

TEST(SelfCalibration, BentLensIsDoubted) {
  CameraRig given = mono();
  given.left.distortion[0] += 0.08;
  const auto fit = fit_calibration(survey(mono(), given));
  ASSERT_TRUE(fit);
  EXPECT_THAT(doubts(*fit), doubt(AlertKind::calibration_suspect, "distortion"));
  EXPECT_LT(fit->refined_rms_px, fit->rms_px);
  EXPECT_NEAR(fit->left.refined.distortion[0], -0.11, 0.04);
}

TEST(SelfCalibration, CalibrationMadeInAirIsNamedSo) {
  CameraRig given = mono();
  given.left.fx /= 1.33;
  given.left.fy /= 1.33;
  given.left.distortion[0] += 0.1;  // is not named beside it
  const auto fit = fit_calibration(survey(mono(), given));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->left.focal_ratio.value, 1.33, 5 * fit->left.focal_ratio.sigma);
  EXPECT_GT(fit->left.distortion_px.value, 1);
  EXPECT_THAT(doubts(*fit), doubt(AlertKind::calibration_suspect, "in air"));
  EXPECT_EQ(doubts(*fit).size(), 1u);
}

TEST(SelfCalibration, LateRightImagesAreMeasured) {
  constexpr double kLate_s = 0.02;
  const auto fit = fit_calibration(survey(pair(), pair(), kLate_s));
  ASSERT_TRUE(fit && fit->pair);
  EXPECT_NEAR(fit->pair->delay_s.value, kLate_s, 0.15 * kLate_s);
  EXPECT_THAT(doubts(*fit), doubt(AlertKind::stereo_skew, "after the left"));
}

TEST(SelfCalibration, PairThatWasKnockedIsDoubted) {
  CameraRig truth = pair();
  truth.right->right_from_left.rotation =
      Eigen::AngleAxisd(0.005, Vector3d::UnitX()) * truth.right->right_from_left.rotation;
  const auto fit = fit_calibration(survey(truth, pair()));
  ASSERT_TRUE(fit && fit->pair);
  EXPECT_NEAR(fit->pair->epipolar_px, 0.005 * 303, 0.4);
  EXPECT_LT(fit->pair->refined_epipolar_px, 2 * kNoise_px);
  EXPECT_THAT(doubts(*fit), doubt(AlertKind::calibration_suspect, "the pair"));
}

TEST(SelfCalibration, TooFewImagesSayNothing) {
  auto few = survey(mono(), mono());
  few.resize(3);
  EXPECT_FALSE(fit_calibration(few));
  EXPECT_FALSE(fit_calibration({}));
}

}  // namespace
}  // namespace nadir::odometry
