// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/simulate/survey.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "nadir/core/check.hpp"
#include "scene.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

Options small(SceneKind scene, int images = 3) {
  Options options;
  options.scene = scene;
  options.images = images;
  options.image_scale = 0.2;
  return options;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

// Calls visit(pixel, point in survey) for some pixels of an image's depth.
template <class Visit>
void for_points(const Survey& survey, int image, Visit visit) {
  const cv::Mat1f depth = survey.depth(image);
  const Rigid3 pose = survey.survey_from_camera(image);
  for (int row = 2; row < depth.rows; row += 5) {
    for (int column = 2; column < depth.cols; column += 5) {
      const double z = static_cast<double>(depth(row, column));
      ASSERT_GT(z, 0);
      const Vector2d pixel(column, row);
      visit(pixel, pose * (z * survey.rig()->left.unproject(pixel)->homogeneous()));
    }
  }
}

class EveryScene : public testing::TestWithParam<SceneKind> {};
INSTANTIATE_TEST_SUITE_P(Survey, EveryScene,
                         testing::Values(SceneKind::pool, SceneKind::transect, SceneKind::reef,
                                         SceneKind::wreck),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EveryScene, DepthLiesOnTheHeightMap) {
  const Survey survey(small(GetParam()));
  const HeightMap map = survey.height_map();
  std::vector<double> errors;
  for_points(survey, 1, [&](const Vector2d&, const Vector3d& x) {
    const Vector3d local = map.survey_from_local.inverse() * x;
    const int column = static_cast<int>(std::lround((local.x() - map.x0) / map.cell));
    const int row = static_cast<int>(std::lround((local.y() - map.y0) / map.cell));
    ASSERT_TRUE(cv::Rect({}, map.z.size()).contains({column, row}));
    errors.push_back(std::abs(static_cast<double>(map.z(row, column)) - local.z()));
  });
  // Half a cell of horizontal distance on slopes of some 0.2.
  EXPECT_LT(median(errors), 0.1 * map.cell);
}

TEST_P(EveryScene, NeighbouringImagesSeeTheSameGround) {
  const Survey survey(small(GetParam()));
  const cv::Mat1f depth = survey.depth(2);
  const Rigid3 camera_from_survey = survey.survey_from_camera(2).inverse();
  std::vector<double> errors;
  int total = 0;
  for_points(survey, 1, [&](const Vector2d&, const Vector3d& x) {
    ++total;
    const Vector3d in_camera = camera_from_survey * x;
    const auto pixel = survey.rig()->left.project(in_camera);
    if (!pixel) return;
    const cv::Point at(cvRound(pixel->x()), cvRound(pixel->y()));
    if (!cv::Rect({}, depth.size()).contains(at)) return;
    errors.push_back(std::abs(static_cast<double>(depth(at)) - in_camera.z()));
  });
  EXPECT_GT(errors.size(), 0.55 * total);  // overlap
  EXPECT_LT(median(errors), 0.01);         // half a pixel of a slope, pixels of 1 to 2 cm
}

TEST_P(EveryScene, PicturesAreExposedAndTextured) {
  const Survey survey(small(GetParam(), 1));
  cv::Mat grey, detail;
  cv::cvtColor(survey.picture(0).left, grey, cv::COLOR_BGR2GRAY);
  const double mean = cv::mean(grey)[0];
  EXPECT_GT(mean, 50);
  EXPECT_LT(mean, 150);
  cv::Laplacian(grey, detail, CV_32F);
  cv::Scalar centre, deviation;
  cv::meanStdDev(detail, centre, deviation);
  EXPECT_GT(deviation[0], 12);  // noise of 2 grey levels alone gives 9
}

TEST(Survey, GivesTheSameBitsAgainWithAnyNumberOfThreads) {
  const Options options = small(SceneKind::reef, 2);
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat one = Survey(options).picture(1).left;
  cv::setNumThreads(3);
  const cv::Mat three = Survey(options).picture(1).left;
  cv::setNumThreads(before);
  EXPECT_EQ(cv::norm(one, three, cv::NORM_INF), 0);
}

TEST(Survey, AnotherSeedIsAnotherDive) {
  Options options = small(SceneKind::pool, 1);
  const Survey first(options);
  options.seed = 2;
  const Survey second(options);
  EXPECT_GT(cv::norm(first.picture(0).left, second.picture(0).left, cv::NORM_INF), 50);
  EXPECT_GT(
      (first.survey_from_camera(0).translation - second.survey_from_camera(0).translation).norm(),
      0.01);
}

TEST(Survey, FramesCarryWhatCaptureDelivers) {
  Options options = small(SceneKind::wreck, 2);
  options.stereo = true;
  const Survey survey(options);
  const Frame frame = survey.frame(1);
  EXPECT_EQ(frame.image, 1u);
  EXPECT_EQ(frame.name, "000001");
  EXPECT_EQ(frame.time, survey.time(1));
  EXPECT_EQ(frame.colour.size(), cv::Size(survey.rig()->left.width, survey.rig()->left.height));
  EXPECT_EQ(frame.colour.type(), CV_8UC3);
  EXPECT_EQ(frame.grey.type(), CV_8UC1);
  EXPECT_EQ(frame.right.type(), CV_8UC1);
  EXPECT_NEAR(*frame.depth, -survey.survey_from_camera(1).translation.z(), 1e-12);
  EXPECT_NEAR(survey.rig()->right->right_from_left.translation.norm(), 0.2, 1e-3);
  EXPECT_TRUE(Survey(small(SceneKind::wreck, 1)).picture(0).right.empty());
}

TEST(Survey, LaserDotsAreGreenWhereTheTruthSaysAndOneSeparationApart) {
  Options options = small(SceneKind::transect, 4);
  options.image_scale = 1;
  options.clear = true;
  const Survey survey(options);
  const auto dots = survey.laser_dots(3);
  ASSERT_EQ(dots.size(), 2u);
  const cv::Mat3b picture = survey.picture(3).left;
  std::vector<Vector3d> places;
  for (const LaserDot& dot : dots) {
    Vector2d sum = Vector2d::Zero();
    double weights = 0;
    for (int row = cvRound(dot.pixel.y()) - 4; row <= cvRound(dot.pixel.y()) + 4; ++row) {
      for (int column = cvRound(dot.pixel.x()) - 4; column <= cvRound(dot.pixel.x()) + 4;
           ++column) {
        const cv::Vec3b& p = picture(row, column);
        const double excess = std::max(0, p[1] - std::max(p[0], p[2]) - 25);
        sum += excess * Vector2d(column, row);
        weights += excess;
      }
    }
    ASSERT_GT(weights, 200);
    EXPECT_LT((sum / weights - dot.pixel).norm(), 0.6);  // pebbles of unequal brightness under it
    places.push_back(dot.depth * survey.rig()->left.unproject(dot.pixel)->homogeneous());
  }
  EXPECT_NEAR((places[1] - places[0]).head<2>().norm(), survey.lasers()->separation, 1e-6);
}

TEST(Survey, HasLasersOnlyOnATransect) {
  for (const bool stereo : {false, true}) {
    Options options = small(SceneKind::transect, 1);
    options.stereo = stereo;
    EXPECT_TRUE(Survey(options).lasers());
  }
  EXPECT_FALSE(Survey(small(SceneKind::pool, 1)).lasers());
}

TEST(Survey, SensorsReadTheTruthWithTheirStatedNoise) {
  Options options = small(SceneKind::reef, 60);
  const Survey survey(options);
  const Profile& p = profile(options.scene);
  const Path path(p, options.seed,
                  [&](double x, double y) { return hills(p, options.seed, x, y); });
  double roll = 0, yaw = 0;
  const auto attitudes = survey.attitude_readings();
  const double number = static_cast<double>(attitudes.size());
  EXPECT_NEAR(number, 1183, 1);  // 59 intervals of 2 s and the last 0.2 s at 10 Hz
  for (const auto& [t, attitude] : attitudes) {
    const Attitude truth = path.at(t).attitude;
    roll += std::pow(attitude.roll - truth.roll, 2) / number;
    yaw += std::remainder(attitude.yaw - truth.yaw, 2 * std::numbers::pi) / number;
  }
  EXPECT_NEAR(std::sqrt(roll), 0.3 * kDegree, 0.05 * kDegree);
  EXPECT_NEAR(yaw, 0.7 * kDegree, 2 * kDegree);
  double depth = 0;
  const auto depths = survey.depth_readings();
  for (const auto& [t, reading] : depths) {
    const Vector3d x = survey_from_local(p) * path.at(t).x_in_local;
    depth += std::pow(reading + x.z(), 2) / static_cast<double>(depths.size());
  }
  EXPECT_NEAR(std::sqrt(depth), 0.01, 0.001);
}

TEST(Survey, RefusesWhatCannotBeSimulated) {
  Options options;
  options.images = -1;
  EXPECT_THROW(Survey{options}, InputError);
  options.images = 1;
  options.image_scale = 0;
  EXPECT_THROW(Survey{options}, InputError);
}

TEST(Survey, KnowsItsScenesByName) {
  for (const SceneKind scene :
       {SceneKind::pool, SceneKind::transect, SceneKind::reef, SceneKind::wreck}) {
    EXPECT_EQ(scene_from(to_string(scene)), scene);
  }
  EXPECT_FALSE(scene_from("lagoon"));
}

}  // namespace
}  // namespace nadir::simulate
