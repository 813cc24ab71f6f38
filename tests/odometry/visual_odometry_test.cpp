// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/visual_odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "nadir/core/check.hpp"
#include "odometry/film.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector3d;

struct Dive {
  std::map<std::uint64_t, ImagePose> poses;
  std::map<std::uint64_t, Health> health;
  std::multiset<std::uint64_t> lost;
  std::vector<Alert> alerts;
  std::vector<std::shared_ptr<const Window>> windows;
  TrackingState state{};

  void take(const Orientation& o) {
    for (const ImagePose& p : o.poses) poses[p.image] = p;
    if (o.shot) health[o.shot->image] = o.health;
    for (const ImageHealth& later : o.later_health) health[later.image] = later.health;
    lost.insert(o.lost.begin(), o.lost.end());
    alerts.insert(alerts.end(), o.alerts.begin(), o.alerts.end());
    if (o.window) windows.push_back(o.window);
    state = o.state;
  }
  const Alert* alert(AlertKind kind) const {
    const auto found = std::find_if(alerts.begin(), alerts.end(),
                                    [kind](const Alert& a) { return a.kind == kind; });
    return found == alerts.end() ? nullptr : &*found;
  }
};

Dive dive(const std::vector<std::shared_ptr<const Shot>>& shots, Config config = {}) {
  VisualOdometry odometry(config, [](const Window&, const auto&) { return SubmapPlacement{}; });
  Dive result;
  for (const auto& shot : shots) result.take(odometry.process(shot));
  result.take(odometry.finish());
  for (const auto& [image, pose] : result.poses) {
    EXPECT_TRUE(pose.survey_from_camera.is_finite()) << image;
    EXPECT_FALSE(result.lost.contains(image)) << image << " is both oriented and lost";
  }
  return result;
}

// Root mean square of the camera positions after the best similarity (scale free) or rigid motion.
double position_rms(const Dive& dive, const std::vector<Rigid3>& path, bool scale_free) {
  Eigen::Matrix3Xd found(3, static_cast<Eigen::Index>(dive.poses.size())), truth = found;
  Eigen::Index k = 0;
  for (const auto& [image, pose] : dive.poses) {
    found.col(k) = pose.survey_from_camera.translation;
    truth.col(k++) = path[image].translation;
  }
  const Eigen::Matrix4d t = Eigen::umeyama(found, truth, scale_free);
  const Eigen::Matrix3Xd moved =
      (t.topLeftCorner<3, 3>() * found).colwise() + t.topRightCorner<3, 1>().eval();
  return std::sqrt((moved - truth).colwise().squaredNorm().mean());
}

std::vector<std::shared_ptr<const Shot>> even_images(int count, std::uint64_t first = 0,
                                                     double grey = 90) {
  const auto rig = std::make_shared<const CameraRig>(small_rig());
  std::vector<std::shared_ptr<const Shot>> shots;
  for (int i = 0; i < count; ++i) {
    shots.push_back(Ground::shot_of(first + static_cast<std::uint64_t>(i), rig,
                                    cv::Mat(240, 320, CV_8U, cv::Scalar(grey))));
  }
  return shots;
}

// One pixel is 3.3 mm on the ground; tie points good to 0.1 px leave about a millimetre.
TEST(VisualOdometry, OrientsEverySparseImageOfAFlatSeabed) {
  const auto path = swimming_path(14);
  const Dive d = dive(film(small_rig(), path));
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_TRUE(d.lost.empty());
  EXPECT_EQ(d.state, TrackingState::tracking);
  EXPECT_LT(position_rms(d, path, true), 0.004);
}

// Of the ground under a rough water surface, 1 in the mean: three trains of waves 36 to 75 px long,
// up to +-25 %, that run 30 to 90 mm from image to image.
double caustics(const Eigen::Vector2d& x_on_ground, std::size_t image) {
  struct Train {
    double azimuth, length, step;  // radians, metres
  };
  double sum = 0;
  for (const auto& [azimuth, length, step] :
       {Train{0.3, 0.25, 0.09}, Train{1.9, 0.17, 0.05}, Train{4.1, 0.12, 0.03}}) {
    const double along = x_on_ground.dot(Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth)));
    sum += std::sin(2 * M_PI * (along - step * static_cast<double>(image)) / length);
  }
  return 1 + 0.25 * sum / 3;
}

// Of a lamp at the camera: 1.25 in the centre, 0.5 in the corners.
double lamp(const Eigen::Vector2d& pixel, const CameraModel& camera) {
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  return 1.25 - 0.75 * (pixel - centre).squaredNorm() / centre.squaredNorm();
}

void light_up(cv::Mat& grey, const CameraModel& camera, const Rigid3& pose, std::size_t image) {
  for (int row = 0; row < grey.rows; ++row) {
    for (int column = 0; column < grey.cols; ++column) {
      const Eigen::Vector2d pixel(column, row);
      const Vector3d ray = pose.rotation * camera.unproject(pixel)->homogeneous();
      const Vector3d x = pose.translation - pose.translation.z() / ray.z() * ray;
      auto& value = grey.at<std::uint8_t>(row, column);
      value = cv::saturate_cast<std::uint8_t>(value * lamp(pixel, camera) *
                                              caustics(x.head<2>(), image));
    }
  }
}

void add_particles(cv::Mat& grey, cv::RNG& random) {
  for (int k = 0; k < 15; ++k) {
    const cv::Point at(random.uniform(0, grey.cols), random.uniform(0, grey.rows));
    cv::circle(grey, at, random.uniform(1, 4), cv::Scalar::all(240), cv::FILLED, cv::LINE_AA);
  }
}

// Light that is even over a tie point's patch leaves it where it is. This one has slopes of 1.4 %
// per pixel, root mean square, which shift the centre of a blob of sigma 2 px by 0.05 px: less than
// the 0.1 px of even light, so poses are held to the same. Those that follow the light are wrong by
// centimetres.
TEST(VisualOdometry, IsNotDraggedByLightThatMoves) {
  const auto path = swimming_path(14);
  cv::RNG random(5);
  const auto shots =
      with_frames(film(small_rig(), path), [&](const auto&, std::size_t i, Frame& frame) {
        frame.grey = frame.grey.clone();
        light_up(frame.grey, frame.rig->left, path[i], i);
        add_particles(frame.grey, random);
        cv::cvtColor(frame.grey, frame.colour, cv::COLOR_GRAY2BGR);
      });
  const Dive d = dive(shots);
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_TRUE(d.lost.empty());
  for (const auto& [image, pose] : d.poses) EXPECT_EQ(pose.submap, 0U) << image;
  EXPECT_LT(position_rms(d, path, true), 0.004);
}

TEST(VisualOdometry, IsMetricWithAPair) {
  const auto path = swimming_path(12);
  const Dive d = dive(film(small_pair(), path));
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_LT(position_rms(d, path, false), 0.006);
}

// Mapped by the left images alone, and said so.
void expect_refused_pair(const Dive& d, const std::vector<Rigid3>& path) {
  const Alert* alert = d.alert(AlertKind::calibration_suspect);
  ASSERT_NE(alert, nullptr);
  EXPECT_LE(*alert->image, 3u);
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_LT(position_rms(d, path, true), 0.01);
}

TEST(VisualOdometry, RefusesPairsThatAreSwapped) {
  const auto path = swimming_path(8);
  CameraRig rig = small_pair();
  rig.right->camera = rig.left;  // the left images are taken by a camera like the left one
  const auto shots = with_frames(film(rig, path), [](const auto&, std::size_t, Frame& frame) {
    std::swap(frame.grey, frame.right);
    cv::cvtColor(frame.grey, frame.colour, cv::COLOR_GRAY2BGR);
  });
  expect_refused_pair(dive(shots), path);
}

TEST(VisualOdometry, RefusesPairsOfDifferentMoments) {
  const auto path = swimming_path(8);
  const auto shots =
      with_frames(film(small_pair(), path), [](const auto& all, std::size_t i, Frame& frame) {
        frame.right = all[std::min(i + 1, all.size() - 1)]->frame->right;
      });
  expect_refused_pair(dive(shots), path);
}

// From image 7 on; two key frames decide.
TEST(VisualOdometry, GoesOnWithoutARightCameraThatFailsOnTheWay) {
  const auto path = swimming_path(14);
  const auto good = film(small_pair(), path);
  using RightOf = std::function<cv::Mat(std::size_t)>;
  const std::map<std::string, RightOf> failures{
      {"frozen", [&](std::size_t) { return good[6]->frame->right; }},
      {"late", [&](std::size_t i) { return good[i - 1]->frame->right; }},
      {"black", [&](std::size_t) { return cv::Mat::zeros(240, 320, CV_8U); }},
      {"left", [&](std::size_t i) { return good[i]->frame->grey; }},
      {"other ground", [&](std::size_t i) { return good[i - 7]->frame->right; }}};
  for (const auto& [failure, right_of] : failures) {
    const RightOf& wrong = right_of;  // clang 14 captures no bindings
    const Dive d = dive(with_frames(good, [&](const auto&, std::size_t i, Frame& frame) {
      if (i >= 7) frame.right = wrong(i);
    }));
    const Alert* alert = d.alert(AlertKind::calibration_suspect);
    ASSERT_NE(alert, nullptr) << failure;
    EXPECT_GE(*alert->image, 7u) << failure;
    EXPECT_LE(*alert->image, 9u) << failure;
    EXPECT_EQ(d.poses.size(), path.size()) << failure;
    EXPECT_LT(position_rms(d, path, false), 0.01) << failure;
  }
}

TEST(VisualOdometry, MapsByTheLeftImagesWhereTheRightShowNothing) {
  const auto path = swimming_path(8);
  const auto shots = with_frames(film(small_pair(), path), [](const auto&, std::size_t, Frame& f) {
    f.right = cv::Mat::zeros(240, 320, CV_8U);
  });
  expect_refused_pair(dive(shots), path);
}

TEST(VisualOdometry, SuspectsNoPairThatFits) {
  EXPECT_EQ(dive(film(small_pair(), swimming_path(6))).alert(AlertKind::calibration_suspect),
            nullptr);
}

TEST(VisualOdometry, TurnsAboutTheOpticalAxis) {
  std::vector<Rigid3> path;
  for (int i = 0; i < 10; ++i) path.push_back(looking_down(0.18 * i, 0, 1, 0.5 * i));
  const Dive d = dive(film(small_rig(), path));
  EXPECT_EQ(d.poses.size(), path.size());
  EXPECT_LT(position_rms(d, path, true), 0.004);
}

TEST(VisualOdometry, OrientsTheImagesBetweenTheKeyFramesOfAVideo) {
  const auto path = swimming_path(40, 0.02);
  const Dive d = dive(film(small_rig(), path));
  EXPECT_EQ(d.poses.size(), path.size());
  const auto key_frames = std::count_if(d.poses.begin(), d.poses.end(),
                                        [](const auto& p) { return p.second.key_frame; });
  EXPECT_LT(key_frames, 30);
  EXPECT_GT(key_frames, 3);
}

// The first ones, too, whose poses come when the map starts.
TEST(VisualOdometry, TellsTheTiePointsOfEveryOrientedImage) {
  const Dive found = dive(film(small_rig(), swimming_path(40, 0.03)));
  ASSERT_EQ(found.poses.size(), 40u);
  for (const auto& [image, pose] : found.poses) {
    const Health& health = found.health.at(image);
    EXPECT_GE(health.tie_points, 40u) << image;
    EXPECT_EQ(health.by_quadrant[0] + health.by_quadrant[1] + health.by_quadrant[2] +
                  health.by_quadrant[3],
              health.tie_points)
        << image;
    EXPECT_GE(health.tracked_length, 2) << image;
    EXPECT_GT(health.rms_px, 0) << image;
    EXPECT_GT(health.sharpness, 0) << image;
  }
}

// Of a normal error 95 % lie within 2 sigma; of 60 images that is 85 % and more but once in a
// thousand.
TEST(VisualOdometry, KnowsHowWellEveryPoseIsKnownRelativeToItsKeyFrame) {
  const auto path = swimming_path(60, 0.03);
  const Dive found = dive(film(small_rig(), path));
  ASSERT_EQ(found.poses.size(), path.size());
  double found_length = 0, length = 0;
  const Rigid3& origin = found.poses.begin()->second.survey_from_camera;
  for (const auto& [image, pose] : found.poses) {
    found_length += (pose.survey_from_camera.translation - origin.translation).norm();
    length += (path[image].translation - path[0].translation).norm();
  }
  const double scale = length / found_length;
  std::uint64_t key = 0;
  int judged = 0, position_within = 0, rotation_within = 0;
  double position_squares = 0, rotation_squares = 0;  // of errors in sigmas
  for (const auto& [image, pose] : found.poses) {
    if (image > 0) {
      ASSERT_GT(pose.sigma_position, 0) << image;
      ASSERT_GT(pose.sigma_rotation, 0) << image;
      const Rigid3 step =
          found.poses.at(key).survey_from_camera.inverse() * pose.survey_from_camera;
      const Rigid3 truth = path[key].inverse() * path[image];
      const double position =
          (scale * step.translation - truth.translation).norm() / (scale * pose.sigma_position);
      const double rotation = step.rotation.angularDistance(truth.rotation) / pose.sigma_rotation;
      ++judged;
      position_within += position < 2;
      rotation_within += rotation < 2;
      position_squares += position * position;
      rotation_squares += rotation * rotation;
    }
    if (pose.key_frame) key = image;
  }
  EXPECT_GE(position_within, 0.85 * judged);
  EXPECT_GE(rotation_within, 0.85 * judged);
  // They are 1 on average; a quarter would be sigmas twice too large.
  EXPECT_GT(position_squares, 0.25 * judged);
  EXPECT_GT(rotation_squares, 0.25 * judged);
}

TEST(VisualOdometry, PublishesAWindowOfTheLastKeyFramesWithColouredTiePoints) {
  const Dive d = dive(film(small_rig(), swimming_path(8)));
  ASSERT_FALSE(d.windows.empty());
  const Window& last = *d.windows.back();
  EXPECT_EQ(last.images.size(), 5U);
  EXPECT_EQ(last.central->image, last.central_pose().image);
  EXPECT_GT(last.tie_points.size(), 100U);
  EXPECT_LT(last.rms_px, 0.5);
  std::set<std::uint64_t> ids;
  for (const TiePoint& t : last.tie_points) {
    EXPECT_TRUE(t.x_in_survey.allFinite());
    EXPECT_TRUE(ids.insert(t.id).second);
    EXPECT_GE(t.images, 2U);
  }
}

TEST(VisualOdometry, MovesTheMapWhereThePlacementPutsIt) {
  const Vector3d there(100, 200, -30);
  VisualOdometry odometry({}, [&](const Window& initial, const auto& frames) {
    EXPECT_EQ(initial.images.size(), frames.size());
    EXPECT_LT(initial.images.front().survey_from_camera.translation.norm(), 1e-9);
    SubmapPlacement placement;
    placement.survey_from_odometry = {7.0, {Eigen::Quaterniond::Identity(), there}};
    placement.scale = {ScaleSource::typed, 0.01};
    return placement;
  });
  Dive d;
  for (const auto& shot : film(small_rig(), swimming_path(5))) d.take(odometry.process(shot));
  EXPECT_LT((d.poses.at(0).survey_from_camera.translation - there).norm(), 1e-6);
  EXPECT_EQ(d.windows.back()->scale.source, ScaleSource::typed);
}

TEST(VisualOdometry, GivesTheSamePosesTwice) {
  const auto shots = film(small_rig(), swimming_path(8));
  const Dive one = dive(shots), two = dive(shots);
  for (const auto& [image, pose] : one.poses) {
    const Rigid3& other = two.poses.at(image).survey_from_camera;
    EXPECT_EQ(pose.survey_from_camera.translation, other.translation);
    EXPECT_EQ(pose.survey_from_camera.rotation.coeffs(), other.rotation.coeffs());
  }
}

TEST(VisualOdometry, StartsNoMapWhereThereIsNothingToSee) {
  const Dive d = dive(even_images(6));
  EXPECT_TRUE(d.poses.empty());
  EXPECT_EQ(d.lost.size(), 6U);
  EXPECT_NE(d.alert(AlertKind::tracking_lost), nullptr);
}

TEST(VisualOdometry, StartsNoMapFromNoise) {
  const auto rig = std::make_shared<const CameraRig>(small_rig());
  std::vector<std::shared_ptr<const Shot>> shots;
  cv::RNG random(3);
  for (std::uint64_t i = 0; i < 6; ++i) {
    cv::Mat noise(240, 320, CV_8U);
    random.fill(noise, cv::RNG::UNIFORM, 0, 255);
    shots.push_back(Ground::shot_of(i, rig, noise));
  }
  const Dive d = dive(shots);
  EXPECT_TRUE(d.poses.empty());
  EXPECT_EQ(d.lost.size(), 6U);
}

TEST(VisualOdometry, StartsNoMapFromOnePlace) {
  const Dive still = dive(film(small_rig(), std::vector<Rigid3>(6, looking_down(0, 0, 1))));
  EXPECT_TRUE(still.poses.empty());
  std::vector<Rigid3> turning;
  for (int i = 0; i < 6; ++i) turning.push_back(looking_down(0, 0, 1, 0.4 * i, 0));
  const Dive turned = dive(film(small_rig(), turning));
  EXPECT_TRUE(turned.poses.empty());
  EXPECT_EQ(turned.lost.size(), 6U);
}

// After water in which nothing is seen, at one image a second.
TEST(VisualOdometry, TellsThatADiveStaysWithoutAMap) {
  constexpr std::size_t kBlank = 3, kStill = 15;
  std::vector<Rigid3> path(kBlank + kStill, looking_down(0, 0, 1));
  for (const Rigid3& pose : swimming_path(8)) path.push_back(pose);
  auto shots = film(small_rig(), path);
  const auto water = even_images(kBlank);
  std::copy(water.begin(), water.end(), shots.begin());
  const Dive d = dive(shots);
  ASSERT_EQ(d.alerts.size(), 3U);
  EXPECT_NE(d.alerts[0].message.find("blank image"), std::string::npos);
  EXPECT_EQ(d.alerts[1].kind, AlertKind::tracking_lost);
  EXPECT_EQ(d.alerts[1].image, kBlank + 10);
  EXPECT_NE(d.alerts[1].message.find("hardly moves"), std::string::npos);
  EXPECT_EQ(d.alerts[2].kind, AlertKind::tracking_recovered);
  EXPECT_GT(d.alerts[2].image, kBlank + kStill);
}

// 0.15 of an image's height a second: more than fit in memory wait for a map, which then starts.
TEST(VisualOdometry, ASlowFilmStartsWithoutAnAlert) {
  constexpr double kInterval = 1.0 / 30;
  std::vector<Rigid3> path;
  for (int i = 0; i < 120; ++i) path.push_back(looking_down(0.12 * kInterval * i, 0, 1));
  const auto shots =
      with_frames(film(small_rig(), path), [&](const auto&, std::size_t i, Frame& frame) {
        frame.time = from_seconds(kInterval * static_cast<double>(i));
      });
  const Dive d = dive(shots);
  EXPECT_TRUE(d.alerts.empty());
  EXPECT_GT(d.poses.size(), 40U);
  EXPECT_FALSE(d.lost.empty());
}

TEST(VisualOdometry, TellsThatImagesThatMoveGiveNoMap) {
  std::vector<Rigid3> turning;
  for (int i = 0; i < 15; ++i) turning.push_back(looking_down(0, 0, 1, 0.4 * i, 0));
  const Dive d = dive(film(small_rig(), turning));
  ASSERT_FALSE(d.alerts.empty());
  EXPECT_EQ(d.alerts[0].image, 10U);
  EXPECT_NE(d.alerts[0].message.find("do not fit each other"), std::string::npos);
}

TEST(VisualOdometry, FindsTheGroundAgainAfterSilt) {
  const auto path = swimming_path(12, 0.12);
  auto shots = film(small_rig(), path);
  const auto silt = even_images(2, 6);
  std::copy(silt.begin(), silt.end(), shots.begin() + 6);
  const Dive d = dive(shots);
  EXPECT_EQ(d.poses.size(), 10U);
  EXPECT_EQ(d.lost, (std::multiset<std::uint64_t>{6, 7}));
  ASSERT_NE(d.alert(AlertKind::tracking_lost), nullptr);
  EXPECT_EQ(d.alert(AlertKind::tracking_lost)->image, 6U);
  ASSERT_NE(d.alert(AlertKind::tracking_recovered), nullptr);
  EXPECT_EQ(d.alert(AlertKind::tracking_recovered)->image, 8U);
  for (const auto& [image, pose] : d.poses) EXPECT_EQ(pose.submap, 0U) << image;
}

TEST(VisualOdometry, TellsWhyAnImageIsBlank) {
  struct Blank {
    double grey;
    std::string reason, remedy;
  };
  const auto film_before = film(small_rig(), swimming_path(6, 0.12));
  for (const auto& [grey, reason, remedy] : {Blank{10, "too dark", "check the lamps"},
                                             Blank{90, "silt or open water", "let silt settle"},
                                             Blank{250, "over-exposed", "dim the lamps"}}) {
    const auto blank = even_images(2, 6, grey);
    auto shots = film_before;
    shots.insert(shots.end(), blank.begin(), blank.end());
    for (const Dive& d : {dive(blank), dive(shots)}) {  // before and after there is a map
      const Alert* alert = d.alert(AlertKind::tracking_lost);
      ASSERT_NE(alert, nullptr);
      EXPECT_EQ(alert->image, 6U);
      EXPECT_NE(alert->message.find("blank image"), std::string::npos);
      EXPECT_NE(alert->message.find(reason), std::string::npos) << alert->message;
      EXPECT_NE(alert->remedy.find(remedy), std::string::npos) << alert->remedy;
    }
  }
}

TEST(VisualOdometry, JudgesBlankImagesByTheThresholdsOfWeakOnes) {
  Config config;
  config.weak_dark = 100;
  const Dive d = dive(even_images(2), config);
  ASSERT_NE(d.alert(AlertKind::tracking_lost), nullptr);
  EXPECT_NE(d.alert(AlertKind::tracking_lost)->message.find("too dark"), std::string::npos);
}

std::vector<std::shared_ptr<const Shot>> jump() {
  auto path = swimming_path(5, 0.15);
  for (int i = 0; i < 5; ++i) path.push_back(looking_down(3 + 0.15 * i, 0.8, 1));
  return film(small_rig(), path);
}

TEST(VisualOdometry, StartsASubmapAtTheImageThatJumped) {
  const Dive d = dive(jump());
  EXPECT_EQ(d.poses.size(), 10U);
  for (const auto& [image, pose] : d.poses) EXPECT_EQ(pose.submap, image < 5 ? 0U : 1U) << image;
  ASSERT_NE(d.alert(AlertKind::tracking_lost), nullptr);
  EXPECT_EQ(d.alert(AlertKind::tracking_lost)->image, 5U);
  EXPECT_FALSE(d.alert(AlertKind::tracking_lost)->remedy.empty());
  ASSERT_NE(d.alert(AlertKind::submap_started), nullptr);
  EXPECT_EQ(d.alert(AlertKind::submap_started)->image, 5U);
}

TEST(VisualOdometry, StartsASubmapWhenToldSo) {
  VisualOdometry odometry({}, [](const Window&, const auto&) { return SubmapPlacement(); });
  std::map<std::uint64_t, std::uint32_t> submaps;
  std::vector<AlertKind> alerts;
  const auto take = [&](const Orientation& out) {
    for (const ImagePose& pose : out.poses) submaps[pose.image] = pose.submap;
    for (const Alert& alert : out.alerts) alerts.push_back(alert.kind);
  };
  const auto shots = film(small_rig(), swimming_path(16, 0.15));
  for (const auto& shot : shots) {
    if (shot->image == 8) odometry.begin_submap();
    take(odometry.process(shot));
  }
  take(odometry.finish());
  EXPECT_EQ(submaps.size(), 16u) << "every image has its place";
  for (const auto& [image, submap] : submaps) EXPECT_EQ(submap, image < 8 ? 0U : 1U) << image;
  EXPECT_EQ(alerts, std::vector{AlertKind::submap_started}) << "nothing was lost";
}

// A print on a mat, a tile: it fills a third of the images after the jump, and what should be
// around it is not.
TEST(VisualOdometry, IsNotBackWhereTheSameThingLiesTwice) {
  Ground ground;
  ground.repeat(0.75, 0.3, 0.4, 0.6, 3.75, 0.3);
  auto path = swimming_path(10, 0.15);
  for (int i = 0; i < 5; ++i) path.push_back(looking_down(3.7 + 0.1 * i, 0, 1));
  const auto rig = std::make_shared<const CameraRig>(small_rig());
  std::vector<std::shared_ptr<const Shot>> shots;
  for (std::size_t i = 0; i < path.size(); ++i) shots.push_back(ground.shot(i, rig, path[i]));
  const Dive d = dive(shots);
  ASSERT_NE(d.alert(AlertKind::tracking_lost), nullptr);
  EXPECT_EQ(d.alert(AlertKind::tracking_lost)->image, 10U);
  for (const auto& [image, pose] : d.poses) EXPECT_EQ(pose.submap, image < 10 ? 0U : 1U) << image;
}

TEST(VisualOdometry, StopsAtALossWhenToldSo) {
  Config config;
  config.on_lost = OnLost::stop;
  const Dive d = dive(jump(), config);
  EXPECT_EQ(d.poses.size(), 5U);
  EXPECT_EQ(d.lost.size(), 5U);
  EXPECT_EQ(d.state, TrackingState::lost);
}

TEST(VisualOdometry, PassesOverRejectedImages) {
  auto shots = film(small_rig(), swimming_path(7, 0.12));
  auto rejected = std::make_shared<Shot>();
  rejected->image = 4;
  shots[4] = rejected;
  const Dive d = dive(shots);
  EXPECT_EQ(d.poses.size(), 6U);
  EXPECT_TRUE(d.lost.empty());
}

TEST(VisualOdometryConfig, NamesTheKeyThatIsOutOfRange) {
  Config config;
  config.window = 1;
  try {
    config.check();
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("odometry.window = 1"), std::string::npos);
  }
}

}  // namespace
}  // namespace nadir::odometry
