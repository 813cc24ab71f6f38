// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/plane/plane_fit.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "nadir/core/check.hpp"

namespace nadir::plane {
namespace {

using Eigen::Vector3d;

const Eigen::Quaterniond kLookDown(0, 1, 0, 0);  // x east, y south, z down

std::vector<ImagePose> cameras_above(const Vector3d& x, double height, double step = 0.3) {
  std::vector<ImagePose> images(3);
  for (int i = 0; i < 3; ++i) {
    auto& pose = images[static_cast<std::size_t>(i)].survey_from_camera;
    pose.rotation = kLookDown;
    pose.translation = x + Vector3d(0, (i - 1) * step, height);
  }
  return images;
}

TiePoint seen(const Vector3d& x, std::uint32_t images = 3) {
  TiePoint point;
  point.x_in_survey = x;
  point.images = images;
  point.rms_px = 0.5;
  return point;
}

// A patch of seabed around `centre` whose normal is `normal`, `size` wide, with Gaussian noise
// across.
std::vector<TiePoint> patch(const Vector3d& centre, const Vector3d& normal, double size,
                            double noise, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-size / 2, size / 2);
  std::normal_distribution<double> gauss(0, 1);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
  std::vector<TiePoint> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d flat(uniform(random), uniform(random), noise * gauss(random));
    points.push_back(seen(centre + turn * flat));
  }
  return points;
}

void add_noise_in_water(std::vector<TiePoint>& points, const Vector3d& centre, int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < count; ++i) {
    points.push_back(seen(centre + Vector3d(uniform(random), uniform(random), uniform(random))));
  }
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

TEST(FitPlane, FindsATiltedSeabedAmongOutliers) {
  const Vector3d centre(3, -4, -12), normal = Vector3d(0.2, -0.1, 1).normalized();
  auto points = patch(centre, normal, 1.5, 0.005, 300);
  add_noise_in_water(points, centre + Vector3d(0, 0, 0.9), 100);
  const Fit fit = fit_plane(points, cameras_above(centre, 2), {});
  ASSERT_TRUE(fit.plane) << fit.why_not;
  // 5 mm over a patch of 0.43 m standard deviation and 300 points: 0.04 degrees per axis.
  EXPECT_LT(angle_deg(fit.plane->normal, normal), 0.2);
  EXPECT_NEAR(fit.plane->distance(centre), 0, 0.002);
  EXPECT_GE(fit.plane->inliers, 300u);
  EXPECT_NEAR(fit.plane->inlier_ratio, fit.plane->inliers / 400.0, 1e-12);
  EXPECT_LT(fit.plane->rms, 0.02);
}

TEST(FitPlane, MeasuresTheNoiseOfAPureSeabed) {
  const auto points = patch({0, 0, -5}, Vector3d::UnitZ(), 2, 0.01, 500);
  const Fit fit = fit_plane(points, cameras_above({0, 0, -5}, 2), {});
  ASSERT_TRUE(fit.plane);
  EXPECT_EQ(fit.plane->inliers, 500u);
  EXPECT_NEAR(fit.plane->rms, 0.01, 0.001);  // 500 samples: 3 % at 1 sigma
}

TEST(FitPlane, TurnsTheNormalTowardsTheCameras) {
  const auto points = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.001, 50);
  auto below = cameras_above({0, 0, 0}, -2);
  for (ImagePose& image : below) image.survey_from_camera.rotation = Eigen::Quaterniond::Identity();
  const Fit up = fit_plane(points, cameras_above({0, 0, 0}, 2), {});
  const Fit down = fit_plane(points, below, {});
  ASSERT_TRUE(up.plane && down.plane);
  EXPECT_GT(up.plane->normal.z(), 0.99);
  EXPECT_LT(down.plane->normal.z(), -0.99);
}

TEST(FitPlane, DoesNotDependOnScaleOrPlace) {
  const Vector3d centre(0.5, 0.2, -3);
  const auto points = patch(centre, Vector3d(0.1, 0, 1).normalized(), 2, 0.02, 200);
  const auto images = cameras_above(centre, 2.5);
  const Fit metric = fit_plane(points, images, {});
  const Vector3d far_away(1e6, -1e6, 40);
  auto moved_points = points;
  auto moved_images = images;
  for (TiePoint& p : moved_points) p.x_in_survey = 0.01 * p.x_in_survey + far_away;
  for (ImagePose& image : moved_images) {
    Vector3d& c = image.survey_from_camera.translation;
    c = 0.01 * c + far_away;
  }
  const Fit moved = fit_plane(moved_points, moved_images, {});
  ASSERT_TRUE(metric.plane && moved.plane);
  EXPECT_EQ(metric.plane->inliers, moved.plane->inliers);
  EXPECT_NEAR(moved.plane->rms, 0.01 * metric.plane->rms, 1e-8);
  EXPECT_NEAR(moved.plane->distance(0.01 * centre + far_away),
              0.01 * metric.plane->distance(centre), 1e-8);
}

TEST(FitPlane, GivesTheSamePlaneTwice) {
  auto points = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.02, 100);
  add_noise_in_water(points, {0, 0, 0.5}, 80);
  const auto images = cameras_above({0, 0, 0}, 2);
  const Fit a = fit_plane(points, images, {}), b = fit_plane(points, images, {});
  ASSERT_TRUE(a.plane && b.plane);
  EXPECT_EQ(a.plane->normal, b.plane->normal);
  EXPECT_EQ(a.plane->offset, b.plane->offset);
}

TEST(FitPlane, RefusesASceneWithoutPlaneAndSaysWhy) {
  std::vector<TiePoint> points;
  add_noise_in_water(points, {0, 0, 0}, 300);
  const Fit fit = fit_plane(points, cameras_above({0, 0, 0}, 2), {});
  EXPECT_FALSE(fit.plane);
  EXPECT_NE(fit.why_not.find("% of the tie points agree"), std::string::npos) << fit.why_not;
}

TEST(FitPlane, LeavesOutPointsThatAreNotFiniteOrWeaklyObserved) {
  auto points = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.001, 40);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) {
    points.push_back(seen({nan, 0, 0}));
    points.push_back(seen({0.001 * i, 0, 0.4}, 1));
    points.push_back(seen({0, 0.001 * i, 0.5}));
    points.back().rms_px = i % 2 == 0 ? 10 : nan;
  }
  const Fit fit = fit_plane(points, cameras_above({0, 0, 0}, 2), {});
  ASSERT_TRUE(fit.plane) << fit.why_not;
  EXPECT_EQ(fit.plane->inliers, 40u);
  EXPECT_EQ(fit.plane->inlier_ratio, 1.0);
}

TEST(FitPlane, HasNoPlaneForDegeneratePoints) {
  const auto images = cameras_above({0, 0, 0}, 2);
  std::vector<TiePoint> few{seen({0, 0, 0}), seen({1, 0, 0})}, identical(20, seen({1, 2, 0})), line,
      empty;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1e-4);
  for (int i = 0; i < 50; ++i) line.push_back(seen({0.02 * i, noise(random), noise(random)}));
  for (const auto* points : {&few, &identical, &line, &empty}) {
    const Fit fit = fit_plane(*points, images, {});
    EXPECT_FALSE(fit.plane);
    EXPECT_FALSE(fit.why_not.empty());
  }
}

TEST(FitPlane, HasNoPlaneEdgeOnToTheCentralViewNorBehindACamera) {
  const auto wall = patch({0, 0, -2}, Vector3d::UnitX(), 1, 0.001, 50);
  EXPECT_FALSE(fit_plane(wall, cameras_above({0.4, 0, 0}, 0), {}).plane);
  const auto floor = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.001, 50);
  auto images = cameras_above({0, 0, 0}, 2);
  images[0].survey_from_camera.translation.z() = -2;
  EXPECT_FALSE(fit_plane(floor, images, {}).plane);
}

TEST(FitPlane, HasNoPlaneWithoutFinitePoses) {
  const auto points = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.001, 50);
  EXPECT_FALSE(fit_plane(points, {}, {}).plane);
  auto images = cameras_above({0, 0, 0}, 2);
  images[1].survey_from_camera.translation.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(fit_plane(points, images, {}).plane);
}

class PlaneFitOverTime : public testing::Test {
 protected:
  Surface fly_over(bool planar) {
    auto window = std::make_shared<Window>();
    window->images = cameras_above({0, 0, 0}, 2);
    window->images[1].image = image_++;
    if (planar) window->tie_points = patch({0, 0, 0}, Vector3d::UnitZ(), 1, 0.001, 50);
    auto orientation = std::make_shared<Orientation>();
    orientation->window = window;
    return fit_.process(orientation);
  }

  PlaneFit fit_{Config{}};
  std::uint64_t image_ = 0;
};

TEST_F(PlaneFitOverTime, WarnsOnceWhilePlanesComeAndGo) {
  EXPECT_TRUE(fly_over(true).alerts.empty());
  const Surface first = fly_over(false);
  ASSERT_EQ(first.alerts.size(), 1u);
  EXPECT_EQ(first.alerts[0].kind, AlertKind::not_planar);
  EXPECT_EQ(first.alerts[0].image, 1u);
  EXPECT_FALSE(first.why_not.empty());
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(fly_over(i % 4 == 0).alerts.empty()) << i;
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(fly_over(true).alerts.empty());
  EXPECT_EQ(fly_over(false).alerts.size(), 1u);
}

TEST_F(PlaneFitOverTime, PassesOnAnOrientationWithoutWindow) {
  const auto orientation = std::make_shared<Orientation>();
  const Surface surface = fit_.process(orientation);
  EXPECT_EQ(surface.orientation, orientation);
  EXPECT_FALSE(surface.plane);
  EXPECT_TRUE(surface.why_not.empty() && surface.alerts.empty());
}

TEST(PlaneConfig, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(Config{}.check());
  EXPECT_THROW(Config{.inlier_distance = 0}.check(), InputError);
  EXPECT_THROW(Config{.min_inlier_ratio = 1.5}.check(), InputError);
  EXPECT_THROW(Config{.max_tilt_deg = 90}.check(), InputError);
}

}  // namespace
}  // namespace nadir::plane
