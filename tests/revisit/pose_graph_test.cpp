// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pose_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;

// Poses on a circle, looking outwards, each with a scale of its own.
std::vector<Similarity3> ring(int count) {
  std::vector<Similarity3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    poses.push_back(
        {1 + 0.1 * std::sin(angle),
         {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d(0.1, 0.2, 1).normalized())),
          {5 * std::cos(angle), 5 * std::sin(angle), 0.3 * i / count}}});
  }
  return poses;
}

Edge exact(const std::vector<Similarity3>& poses, int first, int second) {
  const auto& a = poses[static_cast<std::size_t>(first)];
  const auto& b = poses[static_cast<std::size_t>(second)];
  return {first, second, b.inverse() * a, 0.01, 0.01, 0.01, false};
}

void expect_near(const std::vector<Similarity3>& found, const std::vector<Similarity3>& truth,
                 double tolerance) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((found[i].rigid.translation - truth[i].rigid.translation).norm(), tolerance) << i;
    EXPECT_LT(found[i].rigid.rotation.angularDistance(truth[i].rigid.rotation), tolerance) << i;
    EXPECT_NEAR(found[i].scale, truth[i].scale, tolerance) << i;
  }
}

TEST(PoseGraph, ExactEdgesBringDisplacedPosesBack) {
  const auto truth = ring(20);
  std::vector<Edge> edges;
  for (int i = 0; i < 20; ++i) edges.push_back(exact(truth, i, (i + 1) % 20));
  auto poses = truth;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double drift = 0.01 * static_cast<double>(i);
    poses[i] = Similarity3{1 + drift,
                           {Eigen::Quaterniond(Eigen::AngleAxisd(drift, Vector3d::UnitY())),
                            {drift, -drift, drift}}} *
               poses[i];
  }
  ASSERT_TRUE(optimise(poses, edges, {0}));
  expect_near(poses, truth, 1e-5);
}

TEST(PoseGraph, AWrongRevisitIsOutvotedByRightOnes) {
  const auto truth = ring(20);
  std::vector<Edge> edges;
  for (int i = 0; i + 1 < 20; ++i) edges.push_back(exact(truth, i, i + 1));
  for (const int i : {0, 1, 2}) {
    edges.push_back(exact(truth, 19 - i, i));
    edges.back().robust = true;
  }
  Edge wrong = exact(truth, 4, 14);
  wrong.second_from_first.rigid.translation += Vector3d(3, 0, 0);
  wrong.robust = true;
  edges.push_back(wrong);
  auto poses = truth;
  ASSERT_TRUE(optimise(poses, edges, {0}));
  // Cauchy beyond 3 sigma: an error of 300 sigma pulls with 2 * 9 / 300 sigma; ten steps share it.
  expect_near(poses, truth, 0.05);
}

}  // namespace
}  // namespace nadir::revisit
