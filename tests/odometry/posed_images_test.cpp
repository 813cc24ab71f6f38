// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/posed_images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector3d;
using Shots = std::vector<std::shared_ptr<const Shot>>;

struct Dive {
  std::map<std::uint64_t, ImagePose> poses;
  std::map<std::uint64_t, Health> health;
  std::multiset<std::uint64_t> lost;
  std::vector<Alert> alerts;
  std::vector<std::shared_ptr<const Window>> windows;

  void take(const Orientation& o) {
    for (const ImagePose& p : o.poses) poses[p.image] = p;
    if (o.shot) health[o.shot->image] = o.health;
    for (const ImageHealth& later : o.later_health) health[later.image] = later.health;
    lost.insert(o.lost.begin(), o.lost.end());
    alerts.insert(alerts.end(), o.alerts.begin(), o.alerts.end());
    if (o.window) windows.push_back(o.window);
  }
  const Alert* alert(AlertKind kind) const {
    const auto found = std::find_if(alerts.begin(), alerts.end(),
                                    [kind](const Alert& a) { return a.kind == kind; });
    return found == alerts.end() ? nullptr : &*found;
  }
};

SubmapPlacement unplaced(const Window&, const std::vector<std::shared_ptr<const Frame>>&) {
  ADD_FAILURE() << "poses of the survey frame are not placed";
  return {};
}

Dive dive(const Shots& shots, const GivenPoses& given, const Placement& placement = unplaced) {
  PosedImages images({}, given, placement);
  Dive result;
  for (const auto& shot : shots) result.take(images.process(shot));
  result.take(images.finish());
  for (const auto& [image, pose] : result.poses) EXPECT_FALSE(result.lost.contains(image)) << image;
  EXPECT_EQ(result.poses.size() + result.lost.size(), shots.size());
  return result;
}

std::vector<Rigid3> swimming_path(int images, double step = 0.2) {
  std::vector<Rigid3> path;
  path.reserve(static_cast<std::size_t>(images));
  for (int i = 0; i < images; ++i) {
    path.push_back(looking_down(step * i, 0.1 * std::sin(0.7 * i), 1 + 0.05 * std::cos(0.5 * i),
                                0.15 * std::sin(0.4 * i), 0.03 * std::sin(1.1 * i)));
  }
  return path;
}

Shots film(const CameraRig& rig, const std::vector<Rigid3>& path) {
  static const Ground ground;
  const auto shared = std::make_shared<const CameraRig>(rig);
  Shots shots;
  for (std::size_t i = 0; i < path.size(); ++i) shots.push_back(ground.shot(i, shared, path[i]));
  return shots;
}

GivenPoses in_survey(const std::vector<Rigid3>& path) {
  return {"truth.tum", {path.begin(), path.end()}, true, true};
}

// The same poses in a frame of another origin, axes and unit.
const Similarity3 kElsewhere{0.25,
                             {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), Vector3d(30, -20, 10)}};

GivenPoses elsewhere(const std::vector<Rigid3>& path) {
  GivenPoses given{"model", {}, false, false};
  for (const Rigid3& pose : path) given.map_from_camera.push_back(kElsewhere * pose);
  return given;
}

void expect_the_path(const Dive& d, const std::vector<Rigid3>& path) {
  for (const auto& [image, pose] : d.poses) {
    const Rigid3& given = path[image];
    EXPECT_LT((pose.survey_from_camera.translation - given.translation).norm(), 1e-9) << image;
    EXPECT_LT(pose.survey_from_camera.rotation.angularDistance(given.rotation), 1e-7) << image;
    EXPECT_EQ(pose.submap, 0u);
  }
}

// The ground is z = 0; 0.1 px at 1 m from a base of 0.2 m are 1.7 mm.
double rms_height(const Window& window, double height = 0, double unit = 1) {
  double sum = 0;
  for (const TiePoint& p : window.tie_points) {
    const double z = (p.x_in_survey.z() - height) / unit;
    sum += z * z;
  }
  return std::sqrt(sum / static_cast<double>(window.tie_points.size()));
}

void expect_true_ground(const Dive& d) {
  for (const auto& window : d.windows) {
    EXPECT_GT(window->tie_points.size(), 100u);
    EXPECT_LT(rms_height(*window), 0.004) << window->central->image;
    EXPECT_LT(window->rms_px, 0.5);
  }
}

TEST(PosedImages, KeepTheirPosesAndFindTheGround) {
  const auto path = swimming_path(10);
  const Dive d = dive(film(small_rig(), path), in_survey(path));
  EXPECT_EQ(d.poses.size(), path.size());
  expect_the_path(d, path);
  ASSERT_GE(d.windows.size(), 6u);
  expect_true_ground(d);
  EXPECT_TRUE(d.alerts.empty());
  const Window& last = *d.windows.back();
  EXPECT_EQ(last.images.size(), 5u);
  EXPECT_EQ(last.scale.source, ScaleSource::poses);
  EXPECT_EQ(last.axes, SurveyAxes::poses);
  EXPECT_EQ(last.central->image, last.central_pose().image);
}

// The first two, too, of which nothing was known at their own moment, and those so far apart that
// no image sees the tie points of the two before it (the last has the way of one pair only).
TEST(PosedImages, TellTheirTiePoints) {
  const double width = small_rig().left.width / small_rig().left.fx;  // of an image, from 1 m
  for (const double step : {0.2, 0.6 * width}) {
    const auto path = swimming_path(6, step);
    const Dive found = dive(film(small_rig(), path), in_survey(path));
    for (std::uint64_t image = 0; image < path.size(); ++image) {
      const Health& health = found.health.at(image);
      EXPECT_GE(health.tie_points, 40u) << step << ' ' << image;
      EXPECT_GE(health.tracked_length, 2) << step << ' ' << image;
      EXPECT_GT(health.rms_px, 0) << step << ' ' << image;
      EXPECT_FALSE(health.has(Weakness::few_tie_points)) << step << ' ' << image;
    }
  }
}

TEST(PosedImages, ThatShowNothingOfTheMapAreWeak) {
  const auto path = swimming_path(1);
  const Dive found = dive(film(small_rig(), path), in_survey(path));
  EXPECT_EQ(found.health.at(0).tie_points, 0u);
  EXPECT_TRUE(found.health.at(0).has(Weakness::few_tie_points));
}

TEST(PosedImages, OfAVideoAreNotAllKeyFrames) {
  const auto path = swimming_path(40, 0.02);
  const Dive d = dive(film(small_rig(), path), in_survey(path));
  EXPECT_EQ(d.poses.size(), path.size());
  expect_the_path(d, path);
  const auto key_frames = std::count_if(d.poses.begin(), d.poses.end(),
                                        [](const auto& p) { return p.second.key_frame; });
  EXPECT_LT(key_frames, 30);
  EXPECT_GT(key_frames, 3);
  ASSERT_FALSE(d.windows.empty());
  expect_true_ground(d);
}

TEST(PosedImages, WithoutAPoseAreLostAndToldOnce) {
  const auto path = swimming_path(12, 0.12);
  GivenPoses given = in_survey(path);
  given.map_from_camera[5] = given.map_from_camera[6] = std::nullopt;
  given.map_from_camera.pop_back();
  const Dive d = dive(film(small_rig(), path), given);
  EXPECT_EQ(d.lost, (std::multiset<std::uint64_t>{5, 6, 11}));
  const auto told = [&](AlertKind kind) {
    return std::count_if(d.alerts.begin(), d.alerts.end(),
                         [&](const Alert& a) { return a.kind == kind; });
  };
  EXPECT_EQ(told(AlertKind::tracking_lost), 2);
  EXPECT_EQ(told(AlertKind::tracking_recovered), 1);
  EXPECT_EQ(d.alert(AlertKind::tracking_lost)->image, 5u);
  EXPECT_NE(d.alert(AlertKind::tracking_lost)->message.find("truth.tum"), std::string::npos);
  expect_true_ground(d);
}

TEST(PosedImages, ThatShareNoGroundAreNeverInOneWindow) {
  auto path = swimming_path(5, 0.15);
  for (int i = 0; i < 5; ++i) path.push_back(looking_down(3 + 0.15 * i, 0.8, 1));
  const Dive d = dive(film(small_rig(), path), in_survey(path));
  EXPECT_EQ(d.poses.size(), 10u);
  expect_the_path(d, path);
  int before = 0, after = 0;
  for (const auto& window : d.windows) {
    const bool first = window->images.front().image < 5, last = window->images.back().image < 5;
    EXPECT_EQ(first, last);
    ++(first ? before : after);
  }
  EXPECT_GE(before, 2);
  EXPECT_GE(after, 2);
  expect_true_ground(d);
}

TEST(PosedImages, BlindedBySiltInterruptNothing) {
  const auto path = swimming_path(12, 0.12);
  Shots shots = film(small_rig(), path);
  const auto rig = std::make_shared<const CameraRig>(small_rig());
  cv::RNG random(3);
  for (const std::uint64_t i : {5u, 6u}) {
    cv::Mat silt(240, 320, CV_8U);
    random.fill(silt, cv::RNG::UNIFORM, 0, 255);
    shots[i] = Ground::shot_of(i, rig, silt);
  }
  const Dive d = dive(shots, in_survey(path));
  EXPECT_EQ(d.poses.size(), path.size());
  expect_the_path(d, path);
  for (const auto& window : d.windows) {
    for (const ImagePose& pose : window->images) EXPECT_FALSE(pose.image == 5 || pose.image == 6);
  }
  const bool across = std::any_of(d.windows.begin(), d.windows.end(), [](const auto& w) {
    return w->images.front().image < 5 && w->images.back().image > 6;
  });
  EXPECT_TRUE(across);
  expect_true_ground(d);
}

// As reference::SurveyFrame sizes a map without scale.
SubmapPlacement of_unit_size(const Window& initial,
                             const std::vector<std::shared_ptr<const Frame>>& frames) {
  EXPECT_EQ(initial.images.size(), frames.size());
  for (const auto& frame : frames) EXPECT_TRUE(frame->right.empty());
  SubmapPlacement placement;
  placement.survey_from_odometry = {7, {kElsewhere.rigid.rotation.conjugate(), Vector3d(1, 2, 3)}};
  placement.axes = SurveyAxes::first_plane;
  return placement;
}

TEST(PosedImages, OfAnotherFrameArePlacedOnceAndStayUnscaled) {
  const auto path = swimming_path(8);
  const Dive d = dive(film(small_rig(), path), elsewhere(path), of_unit_size);
  EXPECT_EQ(d.poses.size(), path.size());
  ASSERT_FALSE(d.windows.empty());
  EXPECT_EQ(d.windows.back()->scale.source, ScaleSource::none);
  EXPECT_EQ(d.windows.back()->axes, SurveyAxes::first_plane);
  const double unit = 7 * kElsewhere.scale;
  for (const auto& [image, pose] : d.poses) {
    const Vector3d from_first =
        pose.survey_from_camera.translation - d.poses.at(0).survey_from_camera.translation;
    EXPECT_LT((from_first - unit * (path[image].translation - path[0].translation)).norm(), 1e-9);
  }
  const double ground =
      d.poses.at(0).survey_from_camera.translation.z() - unit * path[0].translation.z();
  for (const auto& window : d.windows) EXPECT_LT(rms_height(*window, ground, unit), 0.004);
}

TEST(PosedImages, TakeTheirScaleFromAPair) {
  const auto path = swimming_path(8);
  const Dive d = dive(film(small_pair(), path), elsewhere(path), of_unit_size);
  ASSERT_FALSE(d.windows.empty());
  const Scale& scale = d.windows.back()->scale;
  EXPECT_EQ(scale.source, ScaleSource::stereo);
  EXPECT_GT(scale.sigma, 0);
  EXPECT_LT(scale.sigma, 0.005);
  const double length =
      (d.poses.at(7).survey_from_camera.translation - d.poses.at(0).survey_from_camera.translation)
          .norm();
  // A disparity of 30 px good to 0.1 px, from some hundred points.
  EXPECT_NEAR(length / (path[7].translation - path[0].translation).norm(), 1, 0.003);
}

TEST(PosedImages, OfAnotherScaleThanThePairAreKeptAndToldSo) {
  const auto path = swimming_path(6);
  const Dive right = dive(film(small_pair(), path), in_survey(path));
  EXPECT_EQ(right.alert(AlertKind::scale_conflict), nullptr);
  auto large = path;
  for (Rigid3& pose : large) pose.translation *= 1.1;
  const Dive d = dive(film(small_pair(), path), in_survey(large));
  expect_the_path(d, large);
  ASSERT_NE(d.alert(AlertKind::scale_conflict), nullptr);
  EXPECT_NE(d.alert(AlertKind::scale_conflict)->message.find("10 % too large"), std::string::npos)
      << d.alert(AlertKind::scale_conflict)->message;
}

TEST(PosedImages, OfOtherImagesAreToldSo) {
  const auto path = swimming_path(8);
  auto wrong = path;
  std::reverse(wrong.begin(), wrong.end());
  const Dive d = dive(film(small_rig(), path), in_survey(wrong));
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_NE(d.alert(AlertKind::calibration_suspect), nullptr);
}

TEST(PosedImages, ThatCannotBePlacedAreLost) {
  const auto path = swimming_path(2);
  const Dive d = dive(film(small_rig(), path), elsewhere(path), unplaced);
  EXPECT_EQ(d.lost.size(), 2u);
  EXPECT_NE(d.alert(AlertKind::tracking_lost), nullptr);
}

}  // namespace
}  // namespace nadir::odometry
