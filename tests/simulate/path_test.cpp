// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "path.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nadir::simulate {
namespace {

using Eigen::Vector3d, std::numbers::pi;

double level(double, double) { return 0; }

class EveryScene : public testing::TestWithParam<SceneKind> {};
INSTANTIATE_TEST_SUITE_P(Path, EveryScene,
                         testing::Values(SceneKind::pool, SceneKind::transect, SceneKind::reef,
                                         SceneKind::wreck),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EveryScene, SwimsOnAtItsSpacingWithoutJumps) {
  const Profile& p = profile(GetParam());
  const Path path(p, 1, level);
  for (int image = 1; image < p.images; ++image) {
    const Vector3d step =
        path.at(path.seconds(image)).x_in_local - path.at(path.seconds(image - 1)).x_in_local;
    EXPECT_GT(step.norm(), 0.5 * p.spacing) << image;
    EXPECT_LT(step.norm(), 1.6 * p.spacing + 0.1) << image;
  }
  for (double t = 0; t < 60; t += 0.01) {
    EXPECT_LT((path.at(t + 0.01).x_in_local - path.at(t).x_in_local).norm(), 0.01) << t;
  }
}

TEST_P(EveryScene, RollsPitchesAndHeavesWithinItsBounds) {
  const Profile& p = profile(GetParam());
  const Path path(p, 1, level);
  double roll = 0, pitch = 0, heave = 0;
  for (double t = 0; t < 120; t += 0.1) {
    const Motion motion = path.at(t);
    roll = std::max(roll, std::abs(motion.attitude.roll));
    pitch = std::max(pitch, std::abs(motion.attitude.pitch));
    heave = std::max(heave, std::abs(motion.x_in_local.z() - p.altitude));
  }
  for (const double swing : {roll / p.wobble, pitch / p.wobble, heave / p.heave}) {
    EXPECT_GT(swing, 0.6);
    EXPECT_LE(swing, 1);
  }
}

TEST(Path, TheCameraLooksDownAndItsTopIsForward) {
  const Profile& p = profile(SceneKind::pool);
  Motion motion;
  motion.attitude.yaw = p.azimuth;
  const Rigid3 local_from_camera = motion.local_from_camera(p);
  EXPECT_LT((local_from_camera.rotation * Vector3d::UnitZ() + Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((local_from_camera.rotation * Vector3d::UnitY() + Vector3d::UnitY()).norm(), 1e-12);
}

TEST(Path, HeadingEastMovesEast) {
  Profile p = profile(SceneKind::pool);
  p.azimuth = pi / 2;
  const Vector3d along = survey_from_local(p).rotation * Vector3d::UnitY();
  EXPECT_LT((along - Vector3d::UnitX()).norm(), 1e-12);
}

// Right side down (positive roll): the camera's axis swings to the left of the path.
TEST(Path, RollAndPitchTurnTheAxisAsTheConventionSays) {
  const Profile& p = profile(SceneKind::pool);
  Motion motion;
  motion.attitude = {0.1, 0, p.azimuth};
  Vector3d axis = motion.local_from_camera(p).rotation * Vector3d::UnitZ();
  EXPECT_NEAR(axis.x(), -std::sin(0.1), 1e-12);
  motion.attitude = {0, 0.1, p.azimuth};  // nose up: the axis swings forward
  axis = motion.local_from_camera(p).rotation * Vector3d::UnitZ();
  EXPECT_NEAR(axis.y(), std::sin(0.1), 1e-12);
}

TEST(Path, ReefPassesGoThereAndBack) {
  const Profile& p = profile(SceneKind::reef);
  const Path path(p, 1, level);
  const double turn = pi * p.pass_gap / 2;
  EXPECT_LT((path.course(p.pass_length).position - Eigen::Vector2d(0, p.pass_length)).norm(), 1e-9);
  const auto back = path.course(p.pass_length + turn + 1e-9);
  EXPECT_LT((back.position - Eigen::Vector2d(p.pass_gap, p.pass_length)).norm(), 1e-6);
  EXPECT_NEAR(back.heading, pi, 1e-9);
  const auto third = path.course(2 * (p.pass_length + turn));
  EXPECT_LT((third.position - Eigen::Vector2d(2 * p.pass_gap, 0)).norm(), 1e-9);
}

}  // namespace
}  // namespace nadir::simulate
