// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The truth against the pixels: discs are found in the images by their grey levels alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/encode.hpp"
#include "nadir/simulate/survey.hpp"

namespace nadir::simulate {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

double median_grey(const cv::Mat1b& grey, const Vector2d& centre, double from, double to) {
  std::vector<double> values;
  const int reach = static_cast<int>(std::ceil(to)) + 1;
  for (int row = cvRound(centre.y()) - reach; row <= cvRound(centre.y()) + reach; ++row) {
    for (int column = cvRound(centre.x()) - reach; column <= cvRound(centre.x()) + reach;
         ++column) {
      const double r = (Vector2d(column, row) - centre).norm();
      if (r < from || r > to) continue;
      values.push_back(grey(row, column));
    }
  }
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

// Centroid of the bright area. Only levels half-way between black and white weigh partly, so that
// neither lamps nor noise within the disc or the plate pull at it.
Vector2d bright_centroid(const cv::Mat1b& grey, const Vector2d& near, double diameter) {
  const double white = median_grey(grey, near, 0, 0.3 * diameter);
  const double black = median_grey(grey, near, 0.62 * diameter, 0.75 * diameter);
  const int reach = static_cast<int>(std::ceil(0.7 * diameter));
  Vector2d sum = Vector2d::Zero();
  double weights = 0;
  for (int row = cvRound(near.y()) - reach; row <= cvRound(near.y()) + reach; ++row) {
    for (int column = cvRound(near.x()) - reach; column <= cvRound(near.x()) + reach; ++column) {
      const Vector2d here(column, row);
      if ((here - near).norm() > 0.7 * diameter) continue;
      const double level = (grey(row, column) - black) / (white - black);
      const double weight = std::clamp((level - 0.2) / 0.6, 0.0, 1.0);
      sum += weight * here;
      weights += weight;
    }
  }
  return sum / weights;
}

// Where the centroid of a disc's image lies: not where its centre is projected.
Vector2d centroid_of_image(const CameraModel& camera, const Rigid3& camera_from_survey,
                           const Target& target) {
  constexpr int kCorners = 90;
  const Vector3d along = target.normal.unitOrthogonal(), across = target.normal.cross(along);
  std::vector<Vector2d> rim;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    const Vector3d x =
        target.x_in_survey + target.disc / 2 * (std::cos(angle) * along + std::sin(angle) * across);
    rim.push_back(*camera.project(camera_from_survey * x));
  }
  const Vector2d base = rim.front();
  Vector2d moment = Vector2d::Zero();
  double area = 0;
  for (int i = 0; i + 1 < kCorners; ++i) {
    const Vector2d a = rim[static_cast<std::size_t>(i)] - base;
    const Vector2d b = rim[static_cast<std::size_t>(i) + 1] - base;
    const double twice = a.x() * b.y() - a.y() * b.x();
    moment += twice * (a + b) / 3;
    area += twice;
  }
  return base + moment / area;
}

cv::Mat1b through_jpeg(const cv::Mat& bgr) {
  const auto decoded = image_io::decode(image_io::encode_jpeg(bgr, 90), bgr.cols, bgr.rows, 1,
                                        image_io::Colour::grey);
  return decoded.image;
}

// Distances, in pixels, between measured centres and stated truth, over some images of a survey.
std::vector<double> disc_errors(const Survey& survey, int every) {
  std::vector<double> errors;
  const auto targets = survey.targets();
  for (int image = 0; image < survey.images(); image += every) {
    const auto sightings = survey.sightings(image);
    if (sightings.empty()) continue;
    const Picture picture = survey.picture(image);
    const cv::Mat1b left = through_jpeg(picture.left);
    const cv::Mat1b right = picture.right.empty() ? cv::Mat1b() : through_jpeg(picture.right);
    const Rigid3 left_from_survey = survey.survey_from_camera(image).inverse();
    for (const Sighting& seen : sightings) {
      const Target& target = *std::find_if(targets.begin(), targets.end(),
                                           [&](const Target& t) { return t.id == seen.id; });
      const CameraRig& rig = *survey.rig();
      const CameraModel& camera = seen.right ? rig.right->camera : rig.left;
      const Rigid3 camera_from_survey =
          seen.right ? rig.right->right_from_left * left_from_survey : left_from_survey;
      const Vector2d eccentric = centroid_of_image(camera, camera_from_survey, target) - seen.pixel;
      const Vector2d measured =
          bright_centroid(seen.right ? right : left, seen.pixel, seen.disc_px) - eccentric;
      errors.push_back((measured - seen.pixel).norm());
    }
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

class EveryScene : public testing::TestWithParam<SceneKind> {};
INSTANTIATE_TEST_SUITE_P(Discs, EveryScene,
                         testing::Values(SceneKind::pool, SceneKind::transect, SceneKind::reef,
                                         SceneKind::wreck),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EveryScene, DiscsAreSeenWhereTheTruthSaysInClearWater) {
  Options options;
  options.scene = GetParam();
  options.images = 7;
  options.image_scale = 0.7;
  options.clear = true;
  const auto errors = disc_errors(Survey(options), 3);
  ASSERT_GE(errors.size(), 2u);
  EXPECT_LT(errors.back(), 0.1);
  std::printf("%zu discs, median %.3f, worst %.3f px\n", errors.size(), errors[errors.size() / 2],
              errors.back());
}

// A particle before a disc moves its centroid; so does noise, by some 0.02 px.
TEST(Discs, AreSeenInBothCamerasThroughNoiseAndParticles) {
  Options options;
  options.images = 13;
  options.stereo = true;
  options.image_scale = 0.7;
  const auto errors = disc_errors(Survey(options), 4);
  ASSERT_GE(errors.size(), 6u);
  EXPECT_LT(errors[errors.size() * 9 / 10 - 1], 0.1);
  std::printf("%zu discs, median %.3f, worst %.3f px\n", errors.size(), errors[errors.size() / 2],
              errors.back());
}

}  // namespace
}  // namespace nadir::simulate
