// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/survey_frame.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nadir::reference {
namespace {

using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;

// A flat seabed at z = -3 of an east-north-up world, seen by three cameras 0.5 m apart along
// heading; the map is given in the first camera's frame, as odometry would.
struct Dive {
  Window window;
  std::vector<std::shared_ptr<const Frame>> frames;
  std::vector<Rigid3> enu_from_camera;
};

constexpr double kHeading = 0.7, kRoll = 0.05, kPitch = -0.08;

Dive dive_in_camera_frame(bool with_attitude, bool stereo, double units_per_metre = 1,
                          Vector3d start = {10, 20, 0}, Time first_time = 0,
                          std::uint64_t first = 0) {
  Dive dive;
  auto rig = std::make_shared<CameraRig>();
  rig->left = {640, 480, 500, 500, 319.5, 239.5, LensModel::brown_conrady, {}};
  if (stereo) rig->right = CameraRig::Right{rig->left, {Quaterniond::Identity(), {-0.1, 0, 0}}};
  const Attitude attitude{kRoll, kPitch, kHeading};
  const Quaterniond enu_from_ned(Eigen::Matrix3d{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}});
  for (int i = 0; i < 3; ++i) {
    auto frame = std::make_shared<Frame>();
    frame->image = first + static_cast<std::uint64_t>(i);
    frame->time = first_time + from_seconds(i);
    frame->rig = rig;
    if (stereo) frame->right = cv::Mat(1, 1, CV_8UC1);
    if (with_attitude) frame->attitude = attitude;
    dive.frames.push_back(frame);
    const Vector3d ahead(std::sin(kHeading), std::cos(kHeading), 0);
    dive.enu_from_camera.push_back(
        {enu_from_ned * attitude.ned_from_body() * rig->body_from_camera, start + 0.5 * i * ahead});
  }
  const Rigid3 camera_from_enu = dive.enu_from_camera.front().inverse();
  for (std::size_t i = 0; i < 3; ++i) {
    ImagePose pose{dive.frames[i]->image,
                   dive.frames[i]->time,
                   0,
                   camera_from_enu * dive.enu_from_camera[i],
                   true,
                   10,
                   0.1};
    pose.survey_from_camera.translation *= units_per_metre;
    dive.window.images.push_back(pose);
  }
  for (int i = 0; i < 49; ++i) {
    const Vector3d on_floor(start.x() + 0.2 * (i % 7 - 3), start.y() + 0.2 * (i / 7 - 3), -3);
    TiePoint point;
    point.x_in_survey = units_per_metre * (camera_from_enu * on_floor);
    dive.window.tie_points.push_back(point);
  }
  return dive;
}

std::optional<Plane> true_plane(const Window& window) {
  const Vector3d a = window.tie_points[0].x_in_survey, b = window.tie_points[6].x_in_survey,
                 c = window.tie_points[42].x_in_survey;
  Plane plane;
  plane.normal = (b - a).cross(c - a).normalized();
  if (plane.normal.z() > 0) plane.normal = -plane.normal;  // towards the first camera
  plane.offset = plane.normal.dot(a);
  return plane;
}

std::optional<Plane> no_plane(const Window&) { return std::nullopt; }

TEST(SurveyFrame, AttitudeMakesEastNorthUpAboutTheCentroid) {
  const Dive dive = dive_in_camera_frame(true, true);
  SurveyFrame survey({}, no_plane);
  const SubmapPlacement placement = survey.place(dive.window, dive.frames);
  EXPECT_EQ(survey.axes(), SurveyAxes::attitude);
  EXPECT_FALSE(placement.uncertain);
  EXPECT_EQ(placement.scale.source, ScaleSource::stereo);
  const Vector3d centre(10, 20, -3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Rigid3 pose = placement.survey_from_odometry * dive.window.images[i].survey_from_camera;
    EXPECT_NEAR((pose.translation - (dive.enu_from_camera[i].translation - centre)).norm(), 0,
                1e-9);
    EXPECT_NEAR(pose.rotation.angularDistance(dive.enu_from_camera[i].rotation), 0, 1e-7);
  }
}

TEST(SurveyFrame, FirstPlaneIsHorizontalWithoutAttitude) {
  const Dive dive = dive_in_camera_frame(false, true);
  SurveyFrame survey({}, true_plane);
  const Similarity3 survey_from_odometry =
      survey.place(dive.window, dive.frames).survey_from_odometry;
  EXPECT_EQ(survey.axes(), SurveyAxes::first_plane);
  for (const TiePoint& point : dive.window.tie_points) {
    EXPECT_NEAR((survey_from_odometry * point.x_in_survey).z(), 0, 1e-9);
  }
  const Rigid3 first = survey_from_odometry * dive.window.images[0].survey_from_camera;
  EXPECT_NEAR(first.translation.z(), 3, 1e-9);
  const Vector3d x = first.rotation * Vector3d::UnitX();
  EXPECT_NEAR(x.y(), 0, 1e-9);
  EXPECT_GT(x.x(), 0.9);
}

TEST(SurveyFrame, WithoutAnyPlaneTheViewingDirectionIsDown) {
  const Dive dive = dive_in_camera_frame(false, true);
  SurveyFrame survey({}, no_plane);
  const Similarity3 placed = survey.place(dive.window, dive.frames).survey_from_odometry;
  EXPECT_EQ(survey.axes(), SurveyAxes::first_camera);
  const Rigid3 pose = placed * dive.window.images[1].survey_from_camera;
  EXPECT_NEAR((pose.rotation * Vector3d::UnitZ() + Vector3d::UnitZ()).norm(), 0, 1e-9);
}

TEST(SurveyFrame, PlaneFarFromTheViewingDirectionGivesNoVertical) {
  const Dive dive = dive_in_camera_frame(false, true);
  const auto wall = [](const Window& window) {
    Plane plane = *true_plane(window);
    plane.normal = Eigen::AngleAxisd(0.8, Vector3d::UnitX()) * plane.normal;
    return std::optional(plane);
  };
  SurveyFrame survey({}, wall);
  survey.place(dive.window, dive.frames);
  EXPECT_EQ(survey.axes(), SurveyAxes::first_camera);
}

TEST(SurveyFrame, MonoIsUnscaledAndSizedByItsViewingDistance) {
  const Dive dive = dive_in_camera_frame(true, false, 7.0);
  SurveyFrame survey({}, no_plane);
  const SubmapPlacement placement = survey.place(dive.window, dive.frames);
  EXPECT_EQ(placement.scale.source, ScaleSource::none);
  EXPECT_EQ(placement.scale.sigma, 0);
  // Cameras 3 m above the floor, tilted by 5 degrees: 3 m is one unit to within the tilt.
  const Rigid3 pose = placement.survey_from_odometry * dive.window.images[0].survey_from_camera;
  EXPECT_NEAR(pose.translation.z(), 1, 0.01);
}

TEST(SurveyFrame, LaterSubmapIsDeadReckonedAtTheSameHeightAndHeading) {
  for (const bool with_attitude : {true, false}) {
    const Dive before = dive_in_camera_frame(with_attitude, false);
    SurveyFrame survey({}, true_plane);
    const Similarity3 placed = survey.place(before.window, before.frames).survey_from_odometry;
    Orientation seen;
    auto window = std::make_shared<Window>(before.window);
    for (ImagePose& pose : window->images)
      pose.survey_from_camera = placed * pose.survey_from_camera;
    for (TiePoint& point : window->tie_points) point.x_in_survey = placed * point.x_in_survey;
    seen.poses = window->images;
    seen.window = window;
    EXPECT_TRUE(survey.observe(seen).empty());

    // Two seconds after the last image, somewhere else and in other units.
    const Dive after =
        dive_in_camera_frame(with_attitude, false, 0.3, {50, -7, 0}, from_seconds(4), 9);
    const SubmapPlacement placement = survey.place(after.window, after.frames);
    EXPECT_TRUE(placement.uncertain);
    const Rigid3 pose = placement.survey_from_odometry * after.window.images[0].survey_from_camera;
    const Vector3d step =
        seen.poses[2].survey_from_camera.translation - seen.poses[1].survey_from_camera.translation;
    const Vector3d expected = seen.poses[2].survey_from_camera.translation + 2 * step;
    EXPECT_NEAR((pose.translation - expected).norm(), 0, 1e-9);
    EXPECT_NEAR(pose.rotation.angularDistance(seen.poses[2].survey_from_camera.rotation), 0, 1e-6);
    const double floor =
        (placement.survey_from_odometry * after.window.tie_points[24].x_in_survey).z();
    const double floor_before = window->tie_points[24].x_in_survey.z();
    EXPECT_NEAR(floor, floor_before,
                0.02);  // the median depth of a tilted view, not the height, is kept
  }
}

// A map of three images, and what its frame says of images after them.
struct Following {
  Dive dive = dive_in_camera_frame(true, true);
  SurveyFrame survey{{}, true_plane};
  std::vector<ImagePose> poses;

  Following() {
    const Similarity3 placed = survey.place(dive.window, dive.frames).survey_from_odometry;
    for (std::size_t i = 0; i < 3; ++i) {
      ImagePose pose = dive.window.images[i];
      pose.survey_from_camera = placed * pose.survey_from_camera;
      poses.push_back(pose);
      Orientation orientation;
      orientation.shot = shot(*dive.frames[i]);
      orientation.poses = {pose};
      EXPECT_TRUE(survey.observe(orientation).empty());
      EXPECT_FALSE(survey.dead_reckon(orientation));
    }
  }

  static std::shared_ptr<const Shot> shot(const Frame& frame) {
    auto made = std::make_shared<Shot>();
    made->image = frame.image;
    made->time = frame.time;
    made->frame = std::make_shared<Frame>(frame);
    return made;
  }

  std::optional<DeadReckoned> lost_after(double seconds, double turned = 0) {
    Frame frame = *dive.frames[2];
    frame.image = 3;
    frame.time += from_seconds(seconds);
    frame.attitude->yaw += turned;
    Orientation orientation;
    orientation.shot = shot(frame);
    EXPECT_TRUE(survey.observe(orientation).empty());
    return survey.dead_reckon(orientation);
  }
};

TEST(SurveyFrame, LostImageIsReckonedByLastMotionAndAttitude) {
  Following d;
  constexpr double kTurn = 0.4;
  const auto place = d.lost_after(1, kTurn);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->image, 3u);
  // Clockwise seen from above.
  const Quaterniond turned =
      Quaterniond(AngleAxisd(-kTurn, Vector3d::UnitZ())) * d.poses[2].survey_from_camera.rotation;
  EXPECT_NEAR(place->survey_from_camera.rotation.angularDistance(turned), 0, 1e-6);
}

// What the sum of n chords misses of an arc, turn^2 / (24 n^2) of its length: 6e-7 m here.
TEST(SurveyFrame, ReckonedWayTurnsWithTheVehicle) {
  constexpr double kCircle = 2 * std::numbers::pi;
  constexpr int kSteps = 1000, kImages = 8;
  for (const double turn : {0.0, 0.4, kCircle / 4, -0.6 * kCircle, 0.6 * kCircle, kCircle}) {
    Following d;
    const Vector3d from = d.poses[2].survey_from_camera.translation;
    const Vector3d velocity = from - d.poses[1].survey_from_camera.translation;
    Vector3d expected = from;
    for (int i = 0; i < kSteps; ++i) {
      const double turned = turn * (i + 0.5) / kSteps;
      expected += AngleAxisd(-turned, Vector3d::UnitZ()) * velocity * 2 / kSteps;
    }
    std::optional<DeadReckoned> place;
    for (int i = 1; i <= kImages; ++i) {
      const double part = static_cast<double>(i) / kImages;
      const double around = i % 2 == 0 ? kCircle : 0;  // headings may be given either way
      place = d.lost_after(2 * part, turn * part - around);
      ASSERT_TRUE(place);
    }
    EXPECT_NEAR((place->survey_from_camera.translation - expected).norm(), 0, 2e-6) << turn;
  }
}

TEST(SurveyFrame, ReckoningGrowsUncertainAndHoldsItsPlaceWhenTheLastMotionIsOld) {
  Following d;
  const auto soon = d.lost_after(1), later = d.lost_after(5), late = d.lost_after(60);
  ASSERT_TRUE(soon && later && late);
  EXPECT_GT(soon->sigma_position, 0.2);  // half a metre a second, that may change
  EXPECT_GT(later->sigma_position, 4 * soon->sigma_position);
  EXPECT_GT(late->sigma_position, 10 * later->sigma_position);
  EXPECT_NEAR((late->survey_from_camera.translation - later->survey_from_camera.translation).norm(),
              0, 1e-9);
  const auto turned = d.lost_after(61, 1);  // long after the way ended
  ASSERT_TRUE(turned);
  EXPECT_NEAR(
      (turned->survey_from_camera.translation - later->survey_from_camera.translation).norm(), 0,
      1e-9);
}

TEST(SurveyFrame, ChangesOfDepthAreReckonedWith) {
  Following d;
  Frame frame = *d.dive.frames[2];
  frame.depth = 10;
  Orientation known;
  known.shot = Following::shot(frame);
  known.poses = {d.poses[2]};
  known.poses[0].image = frame.image = 3;
  known.poses[0].time = frame.time += from_seconds(1);
  known.shot = Following::shot(frame);
  EXPECT_TRUE(d.survey.observe(known).empty());
  frame.image = 4;
  frame.time += from_seconds(1);
  frame.depth = 10.7;
  Orientation lost;
  lost.shot = Following::shot(frame);
  EXPECT_TRUE(d.survey.observe(lost).empty());
  const auto place = d.survey.dead_reckon(lost);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->survey_from_camera.translation.z(),
              known.poses[0].survey_from_camera.translation.z() - 0.7, 1e-9);
}

TEST(SurveyFrame, KnownLengthThatFindsNoGroundIsTold) {
  Config config;
  config.known_length = "99 100 100 300 100 0.5";
  const Dive dive = dive_in_camera_frame(true, false);
  SurveyFrame survey(config, true_plane);
  survey.place(dive.window, dive.frames);
  const auto alerts = survey.observe(Orientation{});
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::scale_conflict);
  EXPECT_NE(alerts[0].message.find("image 99 was not there"), std::string::npos);
}

TEST(SurveyFrame, AhrsThatMakesTheGroundAWallIsToldAndLeftOut) {
  Dive dive = dive_in_camera_frame(true, true);
  for (auto& frame : dive.frames) {
    auto rolled = std::make_shared<Frame>(*frame);
    rolled->attitude->roll += std::numbers::pi / 2;
    frame = rolled;
  }
  SurveyFrame survey({}, true_plane);
  const SubmapPlacement placement = survey.place(dive.window, dive.frames);
  EXPECT_EQ(survey.axes(), SurveyAxes::first_plane);
  for (const TiePoint& point : dive.window.tie_points) {
    EXPECT_NEAR((placement.survey_from_odometry * point.x_in_survey).z(), 0, 1e-9);
  }
  Frame newest = *dive.frames[2];
  newest.image = 7;
  newest.time = from_seconds(7);
  Orientation orientation;
  orientation.shot = Following::shot(newest);
  const auto alerts = survey.observe(orientation);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::calibration_suspect);
  EXPECT_EQ(alerts[0].image, 7u);
  EXPECT_EQ(alerts[0].time, newest.time);
  EXPECT_NE(alerts[0].message.find("slopes by 90 degrees"), std::string::npos);
  EXPECT_NE(alerts[0].remedy.find("capture.mounting_"), std::string::npos);
  EXPECT_FALSE(survey.mark(Following::shot(*dive.frames[0]))->frame->attitude);
}

std::vector<std::shared_ptr<const Frame>> rolled_by(const Dive& dive, double roll) {
  std::vector<std::shared_ptr<const Frame>> frames;
  for (const auto& frame : dive.frames) {
    auto rolled = std::make_shared<Frame>(*frame);
    rolled->attitude->roll += roll;
    frames.push_back(rolled);
  }
  return frames;
}

TEST(SurveyFrame, SteepGroundFacedSquarelyIsNoFaultOfTheAhrs) {
  const Dive dive = dive_in_camera_frame(true, true);
  for (const double slope : {0.0, 0.9}) {  // of the first map's ground
    SurveyFrame survey({}, true_plane);
    EXPECT_EQ(survey.place(dive.window, rolled_by(dive, slope)).axes, SurveyAxes::attitude);
    EXPECT_EQ(survey.place(dive.window, rolled_by(dive, 1.4)).axes, SurveyAxes::attitude);
    EXPECT_TRUE(survey.observe(Orientation{}).empty());
  }
}

TEST(SurveyFrame, LaterSubmapIsTaggedByWhatLevelledIt) {
  const Dive dive = dive_in_camera_frame(true, true), bare = dive_in_camera_frame(false, true);
  bool has_plane = true;
  SurveyFrame survey(
      {}, [&](const Window& window) { return has_plane ? true_plane(window) : std::nullopt; });
  EXPECT_EQ(survey.place(dive.window, dive.frames).axes, SurveyAxes::attitude);
  EXPECT_EQ(survey.place(bare.window, bare.frames).axes, SurveyAxes::first_plane);
  has_plane = false;
  EXPECT_EQ(survey.place(bare.window, bare.frames).axes, SurveyAxes::first_camera);
  EXPECT_EQ(survey.place(dive.window, dive.frames).axes, SurveyAxes::attitude);
  EXPECT_EQ(survey.axes(), SurveyAxes::attitude);
}

TEST(SurveyFrame, CameraMountedToLookAheadMaySeeAWall) {
  Dive dive = dive_in_camera_frame(true, true);
  const Quaterniond ahead(AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()));
  auto rig = std::make_shared<CameraRig>(*dive.frames[0]->rig);
  rig->body_from_camera = ahead * rig->body_from_camera;
  for (auto& frame : dive.frames) {
    auto mounted = std::make_shared<Frame>(*frame);
    mounted->rig = rig;
    frame = mounted;
  }
  SurveyFrame survey({}, true_plane);
  survey.place(dive.window, dive.frames);
  EXPECT_EQ(survey.axes(), SurveyAxes::attitude);
  EXPECT_TRUE(survey.observe(Orientation{}).empty());
}

TEST(SurveyFrame, AhrsThatTurnsTheOtherWayIsToldOnceAndLeftOut) {
  Following d;
  std::size_t told = 0;
  for (int i = 3; i < 60; ++i) {
    Frame frame = *d.dive.frames[2];
    frame.image = static_cast<std::uint64_t>(i);
    frame.time = from_seconds(i);
    const double roll = 0.05 * std::sin(i);
    frame.attitude->roll -= roll;
    ImagePose pose = d.poses[2];
    pose.image = frame.image;
    pose.time = frame.time;
    const Quaterniond rolled(AngleAxisd(roll, Vector3d::UnitX()));
    const Quaterniond& mounted = frame.rig->body_from_camera;
    pose.survey_from_camera.rotation =
        pose.survey_from_camera.rotation * mounted.conjugate() * rolled * mounted;
    Orientation orientation;
    orientation.shot = d.survey.mark(Following::shot(frame));
    EXPECT_EQ(orientation.shot->frame->attitude.has_value(), told == 0);
    orientation.poses = {pose};
    for (const Alert& alert : d.survey.observe(orientation)) {
      ++told;
      EXPECT_EQ(alert.kind, AlertKind::calibration_suspect);
      EXPECT_NE(alert.message.find("in roll it turns by -"), std::string::npos);
    }
    EXPECT_EQ(d.survey.axes(), told == 0 ? SurveyAxes::attitude : SurveyAxes::doubtful);
  }
  EXPECT_EQ(told, 1u);
}

// The grid's north lies west of true north here: what points north has a bearing of its own on it.
TEST(SurveyFrame, WithAnOriginTheGridsNorthIsY) {
  Config config;
  config.origin = "60.4 3.2";
  const double convergence = UtmGrid({60.4, 3.2, 0}).convergence();
  ASSERT_LT(convergence, -0.08);
  Dive dive = dive_in_camera_frame(true, true);
  SurveyFrame survey(config, no_plane);
  for (auto& frame : dive.frames) frame = survey.mark(Following::shot(*frame))->frame;
  const Rigid3 pose = survey.place(dive.window, dive.frames).survey_from_odometry.rigid *
                      dive.window.images[2].survey_from_camera;
  EXPECT_EQ(survey.axes(), SurveyAxes::attitude);
  const Quaterniond grid_from_enu(AngleAxisd(convergence, Vector3d::UnitZ()));
  const Vector3d centre(10, 20, -3);
  EXPECT_NEAR(pose.rotation.angularDistance(grid_from_enu * dive.enu_from_camera[2].rotation), 0,
              1e-7);
  EXPECT_NEAR(
      (pose.translation - grid_from_enu * (dive.enu_from_camera[2].translation - centre)).norm(), 0,
      1e-9);
  Orientation seen;
  seen.shot = Following::shot(*dive.frames[2]);
  EXPECT_TRUE(survey.observe(seen).empty());
}

TEST(SurveyFrame, OriginThatCannotPlaceTheMapIsToldOnce) {
  Config config;
  config.origin = "60.4 3.2";
  const Dive dive = dive_in_camera_frame(false, true);
  SurveyFrame survey(config, true_plane);
  Orientation seen;
  seen.shot = Following::shot(*dive.frames[2]);
  EXPECT_TRUE(survey.observe(seen).empty());  // not known yet
  survey.place(dive.window, dive.frames);
  const auto alerts = survey.observe(seen);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::sensor_stale);
  EXPECT_EQ(alerts[0].image, 2u);
  EXPECT_NE(alerts[0].message.find("reference.origin"), std::string::npos);
  EXPECT_TRUE(survey.observe(seen).empty());
}

TEST(SurveyFrame, LasersThatNobodySeesAreTold) {
  const Dive dive = dive_in_camera_frame(true, true);
  calibration::Lasers lasers;
  lasers.separation = 0.1;
  lasers.parallel_to_optical_axis = true;
  lasers.origins_in_camera = {{-0.05, 0.06, 0}, {0.05, 0.06, 0}};
  SurveyFrame survey({}, true_plane, lasers);
  survey.place(dive.window, dive.frames);
  std::vector<Alert> alerts;
  for (std::uint64_t i = 0; i < 60; ++i) {
    Orientation orientation;
    orientation.shot = Following::shot(*dive.frames[0]);
    orientation.poses = {dive.window.images[0]};
    orientation.poses[0].image = i;
    orientation.poses[0].time = from_seconds(0.1 * static_cast<double>(i));  // of a film
    for (const Alert& alert : survey.observe(orientation)) alerts.push_back(alert);
  }
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::sensor_stale);
  EXPECT_NE(alerts[0].message.find("0 of 51 images"), std::string::npos);
}

}  // namespace
}  // namespace nadir::reference
