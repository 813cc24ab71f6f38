// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/bundle_adjustment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "normal_equations.hpp"
#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

struct Scene {
  Adjustment truth, start;  // start: noisy observations, poses and points displaced
};

// Five images of 120 points in a slab below; the first `fixed` are held at the truth.
Scene scene(const CameraRig& rig, double noise_px, int fixed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  Scene s;
  for (int i = 0; i < 5; ++i) {
    s.truth.images.push_back({looking_down(0.2 * i, 0, 1, 0.1 * i).inverse(), i < fixed, false});
  }
  for (int k = 0; k < 120; ++k) {
    s.truth.points.push_back(
        {{0.4 + uniform(random), 0.6 * uniform(random), 0.1 * uniform(random)}, false});
  }
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 120; ++k) {
      const Vector3d x = s.truth.images[static_cast<std::size_t>(i)].camera_from_map *
                         s.truth.points[static_cast<std::size_t>(k)].x_in_map;
      const auto observe = [&](const Vector3d& seen, const CameraModel& camera, bool right) {
        const auto pixel = camera.project(seen);
        if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 319 || pixel->y() > 239)
          return;
        const Vector2d noise(normal(random), normal(random));
        s.truth.observations.push_back(
            {i, k, right, seen.hnormalized() + noise_px / camera.fx * noise});
      };
      observe(x, rig.left, false);
      if (rig.right) observe(rig.right->right_from_left * x, rig.right->camera, true);
    }
  }
  s.start = s.truth;
  for (auto& image : s.start.images) {
    if (image.fixed) continue;
    image.camera_from_map.translation +=
        0.02 * Vector3d(uniform(random), uniform(random), uniform(random));
    image.camera_from_map.rotation = image.camera_from_map.rotation *
                                     Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Vector3d::UnitY()));
  }
  for (auto& point : s.start.points)
    point.x_in_map += 0.02 * Vector3d(uniform(random), uniform(random), uniform(random));
  return s;
}

double position_error(const Adjustment& a, const Adjustment& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    worst = std::max(worst, (a.images[i].camera_from_map.inverse().translation -
                             b.images[i].camera_from_map.inverse().translation)
                                .norm());
  }
  return worst;
}

TEST(BundleAdjustment, RecoversTheTruthExactlyWithoutNoise) {
  Scene s = scene(small_rig(), 0, 2);
  const auto summary = adjust(s.start, small_rig(), {1.0, 50});
  EXPECT_TRUE(summary.usable);
  EXPECT_LT(summary.rms_px, 1e-3);
  EXPECT_LT(position_error(s.start, s.truth), 1e-4);
}

// 0.2 px of 300 at 1 m is 0.7 mm on the ground; some 40 points determine each pose, sideways motion
// and tilt apart only by the edges of the image (a factor of about 6), the last is two images away
// from the nearest fixed one.
TEST(BundleAdjustment, StaysWithinTheNoise) {
  Scene s = scene(small_rig(), 0.2, 2);
  const auto summary = adjust(s.start, small_rig());
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(position_error(s.start, s.truth), 0.007);
  // What is estimated takes its part of the noise: three numbers a point, as far as its images tell
  // so many, and six a free image.
  std::map<int, int> views;
  for (const auto& observation : s.truth.observations) ++views[observation.point];
  double estimated = 6 * 3;
  for (const auto& [point, count] : views) estimated += std::min(3, 2 * count);
  const double measured = 2 * static_cast<double>(s.truth.observations.size());
  const double expected = 0.2 * std::sqrt(2 * (1 - estimated / measured));
  EXPECT_NEAR(summary.rms_px, expected, 4 * expected / std::sqrt(2 * (measured - estimated)));
}

TEST(BundleAdjustment, LeavesFixedImagesUntouched) {
  Scene s = scene(small_rig(), 0.2, 2);
  adjust(s.start, small_rig());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(s.start.images[i].camera_from_map.translation,
              s.truth.images[i].camera_from_map.translation);
  }
}

TEST(BundleAdjustment, TakesTheScaleFromAPair) {
  Scene s = scene(small_pair(), 0.1, 1);
  for (auto& point : s.start.points) point.x_in_map *= 1.02;
  adjust(s.start, small_pair(), {1.0, 50});
  EXPECT_LT(position_error(s.start, s.truth), 0.003);
}

TEST(BundleAdjustment, KeepsADistanceThatHoldsTheScale) {
  Scene s = scene(small_rig(), 0.1, 1);
  const Rigid3 first_from_map = s.truth.images[0].camera_from_map;
  for (Adjustment* a : {&s.start, &s.truth}) {
    for (auto& image : a->images)
      image.camera_from_map = image.camera_from_map * first_from_map.inverse();
    for (auto& point : a->points) point.x_in_map = first_from_map * point.x_in_map;
  }
  s.start.images[1].distance_fixed = true;
  const double distance = s.start.images[1].camera_from_map.translation.norm();
  EXPECT_TRUE(adjust(s.start, small_rig()).usable);
  EXPECT_NEAR(s.start.images[1].camera_from_map.translation.norm(), distance, 1e-9);
}

TEST(BundleAdjustment, IsNotDraggedByAFewFish) {
  Scene s = scene(small_rig(), 0.1, 2);
  for (std::size_t k = 0; k < s.start.observations.size(); k += 25) {
    s.start.observations[k].ray.x() += 15.0 / 300;
  }
  adjust(s.start, small_rig(), {1.0, 50});
  EXPECT_LT(position_error(s.start, s.truth), 0.006);
}

TEST(BundleAdjustment, ChangesNothingWhenTheInputIsNoNumber) {
  Scene s = scene(small_rig(), 0, 2);
  s.start.images[3].camera_from_map.translation.x() = std::nan("");
  s.start.points[5].x_in_map.y() = std::nan("");
  const auto before = s.start.images[4].camera_from_map.translation;
  const auto summary = adjust(s.start, small_rig());
  EXPECT_TRUE(!summary.usable || s.start.images[4].camera_from_map.is_finite());
  if (!summary.usable) {
    EXPECT_EQ(s.start.images[4].camera_from_map.translation, before);
  }
}

TEST(BundleAdjustment, LeavesOutWhatIsNoNumber) {
  Scene s = scene(small_rig(), 0, 2);
  s.start.observations[7].ray.y() = std::nan("");
  s.start.images.push_back({s.truth.images[4].camera_from_map, false, false});  // sees nothing
  const Rigid3 unseen = s.start.images.back().camera_from_map;
  const auto summary = adjust(s.start, small_rig(), {1.0, 50});
  EXPECT_TRUE(summary.usable && summary.converged);
  EXPECT_EQ(s.start.images.back().camera_from_map.translation, unseen.translation);
  s.start.images.pop_back();
  EXPECT_LT(position_error(s.start, s.truth), 1e-6);
}

TEST(BundleAdjustment, AcceptsAnEmptyProblem) {
  Adjustment a;
  a.images = {{{}, false, false}};
  const auto summary = adjust(a, small_rig());
  EXPECT_EQ(summary.rms_px, 0);
  EXPECT_TRUE(a.images[0].camera_from_map.is_finite());
}

// Three images of flat ground, one after the other, with tie points about their common centre only:
// tilt and sideways motion are hardly told apart.
Adjustment flat(double noise_px, unsigned seed) {
  const CameraRig rig = small_rig();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal(0, noise_px / rig.left.fx);
  const Vector3d up(0, 0, -1);  // of cameras that look straight down
  Adjustment a;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Quaterniond lean(Eigen::AngleAxisd(0.03 * i, Vector3d::UnitY()));
    a.images.push_back({Rigid3{lean, {0.1 * i, 0, 0}}.inverse(), i == 0, i == 1});
    a.verticals.push_back({i, a.images.back().camera_from_map.rotation * up, 0.005});
  }
  for (int k = 0; k < 30; ++k) {
    a.points.push_back({{0.1 + 0.15 * uniform(random), 0.15 * uniform(random), 1}, false});
    for (int i = 0; i < 3; ++i) {
      const Vector3d x =
          a.images[static_cast<std::size_t>(i)].camera_from_map * a.points.back().x_in_map;
      a.observations.push_back(
          {i, k, false, x.hnormalized() + Vector2d(normal(random), normal(random))});
    }
  }
  return a;
}

double tilt_error(const Adjustment& a, const Adjustment& b) {
  return a.images[2].camera_from_map.rotation.angularDistance(b.images[2].camera_from_map.rotation);
}

struct TiltErrors {
  double without = 0, with = 0, of_tilted_map = 0, forced = 0;  // root mean squares, radians
};

// Of 20 maps; the tilted ones are given in a frame whose vertical nobody knows.
TiltErrors tilt_errors() {
  constexpr int kMaps = 20;
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.05, Vector3d(1, 2, 0).normalized()));
  TiltErrors sum;
  const auto add = [&](double& to, Adjustment a, const Adjustment& truth) {
    EXPECT_TRUE(adjust(a, small_rig(), {1.0, 100}).usable);
    to += std::pow(tilt_error(a, truth), 2) / kMaps;
  };
  for (unsigned seed = 0; seed < kMaps; ++seed) {
    const Adjustment truth = flat(0.2, seed);
    add(sum.with, truth, truth);
    Adjustment other = truth;
    other.verticals.clear();
    add(sum.without, other, truth);
    other = truth;
    for (auto& vertical : other.verticals) {
      const auto& pose = truth.images[static_cast<std::size_t>(vertical.image)].camera_from_map;
      vertical.up_in_camera = pose.rotation * (turned * Vector3d(0, 0, -1));
    }
    add(sum.of_tilted_map, other, truth);
    other.up_in_map = Vector3d(0, 0, -1);
    add(sum.forced, other, truth);
  }
  for (double* value : {&sum.without, &sum.with, &sum.of_tilted_map, &sum.forced}) {
    *value = std::sqrt(*value);
  }
  return sum;
}

TEST(BundleAdjustment, VerticalsHoldTheTiltWhereTiePointsHardlyDo) {
  const TiltErrors errors = tilt_errors();
  EXPECT_LT(errors.with, 0.7 * errors.without) << errors.without;
}

TEST(BundleAdjustment, VerticalsOfATiltedMapAgreeWithEachOther) {
  const TiltErrors errors = tilt_errors();
  EXPECT_LT(errors.of_tilted_map, 1.1 * errors.with);
  EXPECT_GT(errors.forced, 2 * errors.of_tilted_map);
}

TEST(BundleAdjustment, VerticalsWeighLittleAgainstManyTiePoints) {
  Scene s = scene(small_rig(), 0.2, 2);
  for (int i = 2; i < 5; ++i) {
    const auto& pose = s.truth.images[static_cast<std::size_t>(i)].camera_from_map;
    const Eigen::Quaterniond off(Eigen::AngleAxisd(0.03, Vector3d::UnitY()));
    s.start.verticals.push_back({i, off * (pose.rotation * Vector3d::UnitZ()), 0.035});
  }
  s.start.up_in_map = Vector3d::UnitZ();
  ASSERT_TRUE(adjust(s.start, small_rig()).usable);
  EXPECT_LT(position_error(s.start, s.truth), 0.007);  // as without
}

// A noisy scene with what sensors say of its free images, without error.
struct Sensed {
  Scene scene;
  Adjustment with_heights, with_headings;
};

Sensed sensed() {
  Sensed s{scene(small_rig(), 3, 2), {}, {}};
  s.with_heights = s.with_headings = s.scene.start;
  for (int i = 2; i < 5; ++i) {
    const Rigid3& pose = s.scene.truth.images[static_cast<std::size_t>(i)].camera_from_map;
    s.with_heights.heights.push_back({i, pose.inverse().translation.z(), 0.0002});
    s.with_headings.headings.push_back({i, pose.rotation.conjugate(), 0.0002});
  }
  return s;
}

double height_error(const Adjustment& a, const Adjustment& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const double one = a.images[i].camera_from_map.inverse().translation.z();
    const double other = b.images[i].camera_from_map.inverse().translation.z();
    largest = std::max(largest, std::abs(one - other));
  }
  return largest;
}

double largest_turn(const Adjustment& a, const Adjustment& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const auto turn =
        a.images[i].camera_from_map.rotation.conjugate() * b.images[i].camera_from_map.rotation;
    largest = std::max(largest, std::abs(2 * std::atan2(turn.z(), turn.w())));
  }
  return largest;
}

// What the sensors' 0.0002 hold to three of it, tie points alone leave ten times as far off.
void expect_held(Scene scene, Adjustment with,
                 double (*error)(const Adjustment&, const Adjustment&)) {
  ASSERT_TRUE(adjust(scene.start, small_rig(), {1.0, 50}).usable);
  ASSERT_TRUE(adjust(with, small_rig(), {1.0, 50}).usable);
  EXPECT_GT(error(scene.start, scene.truth), 0.002);
  EXPECT_LT(error(with, scene.truth), 3 * 0.0002);
}

TEST(BundleAdjustment, HeightsHoldTheHeight) {
  const Sensed s = sensed();
  expect_held(s.scene, s.with_heights, height_error);
}

TEST(BundleAdjustment, HeadingsHoldTheHeading) {
  const Sensed s = sensed();
  expect_held(s.scene, s.with_headings, largest_turn);
}

TEST(BundleAdjustment, RangesHoldTheScaleOfASingleCamera) {
  Scene s = scene(small_rig(), 0.1, 1);
  const Rigid3 first = s.truth.images[0].camera_from_map;
  for (auto& image : s.start.images) {
    const Rigid3 first_from_camera = first * image.camera_from_map.inverse();
    image.camera_from_map =
        Rigid3{first_from_camera.rotation, 1.05 * first_from_camera.translation}.inverse() * first;
  }
  for (auto& point : s.start.points) {
    point.x_in_map = first.inverse() * (1.05 * (first * point.x_in_map));
  }
  for (std::size_t k = 0; k < s.start.observations.size(); k += 20) {
    const auto& o = s.start.observations[k];
    const auto image = static_cast<std::size_t>(o.image), point = static_cast<std::size_t>(o.point);
    const double depth =
        (s.truth.images[image].camera_from_map * s.truth.points[point].x_in_map).z();
    s.start.ranges.push_back({o.image, o.point, depth, 0.005});
  }
  ASSERT_TRUE(adjust(s.start, small_rig(), {1.0, 100}).usable);
  EXPECT_LT(position_error(s.start, s.truth), 0.005);
}

// As a Gauss-Newton step does near the solution; with a wrong derivative it would not.
TEST(BundleAdjustment, FallsAsItsDerivativesSay) {
  for (const CameraRig& rig : {small_rig(), small_pair()}) {
    Scene s = scene(rig, 0.1, 1);
    for (int i = 1; i < 5; ++i) {
      const Rigid3& pose = s.truth.images[static_cast<std::size_t>(i)].camera_from_map;
      s.start.verticals.push_back({i, pose.rotation * Vector3d::UnitZ(), 0.002});
      s.start.headings.push_back({i, pose.rotation.conjugate(), 0.002});
      s.start.heights.push_back({i, pose.inverse().translation.z(), 0.002});
    }
    for (std::size_t k = 0; k < s.start.observations.size(); k += 5) {
      const auto& o = s.start.observations[k];
      const auto image = static_cast<std::size_t>(o.image);
      const auto point = static_cast<std::size_t>(o.point);
      const double depth =
          (s.truth.images[image].camera_from_map * s.truth.points[point].x_in_map).z();
      s.start.ranges.push_back({o.image, o.point, depth, 0.002});
    }
    ASSERT_TRUE(adjust(s.start, rig, {1e3, 50, 1e-12}).usable);
    NormalEquations equations(s.start, rig, 1e3);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    for (int trial = 0; trial < 5; ++trial) {
      Unknowns near = equations.start();
      for (std::size_t i = 1; i < near.camera_from_map.size(); ++i) {
        const Vector3d turn = 1e-5 * vector();
        near.camera_from_map[i] =
            Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())),
                   1e-5 * vector()} *
            near.camera_from_map[i];
      }
      for (auto& x : near.points) x += 1e-5 * vector();
      near.up = (near.up + 1e-5 * vector()).normalized();
      equations.linearise(near);
      const auto step = equations.step(near, 1e-9);
      ASSERT_TRUE(step);
      const double fallen = equations.cost(near) - equations.cost(step->there);
      EXPECT_NEAR(fallen / step->expected, 1, 0.01);
    }
  }
}

}  // namespace
}  // namespace nadir::odometry
