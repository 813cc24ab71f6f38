// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/revisit/revisit.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "link.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "revisit/seabed.hpp"

namespace nadir::revisit {
namespace {

using Eigen::Vector3d;
using odometry::looking_down;

// There along y = 0, back along y = 0.5: the images of the two lanes overlap.
std::vector<Rigid3> two_lanes() {
  std::vector<Rigid3> way;
  for (int i = 0; i < 12; ++i) way.push_back(looking_down(0.3 * i, 0, 1.5, 0, 0.03));
  for (int i = 0; i < 4; ++i) {
    way.push_back(looking_down(3.3 + 0.1 * i, 0.12 * (i + 1), 1.5, 0.75 * (i + 1), 0.03));
  }
  for (int i = 0; i < 12; ++i) way.push_back(looking_down(3.3 - 0.3 * i, 0.5, 1.5, M_PI, 0.03));
  return way;
}

// What odometry's errors have grown to after so many key frames.
Similarity3 drift(std::size_t steps) {
  const double by = static_cast<double>(steps);
  return {1 + 0.003 * by,
          {Eigen::Quaterniond(Eigen::AngleAxisd(0.002 * by, Vector3d::UnitZ())),
           {0.004 * by, -0.003 * by, 0.002 * by}}};
}

struct Outcome {
  Corrections corrections;
  std::vector<Join> joins;
  std::vector<Alert> alerts;
};

void take(const Revision& revision, Outcome& outcome) {
  for (const auto& c : revision.corrections) outcome.corrections.add(c);
  outcome.joins.insert(outcome.joins.end(), revision.joins.begin(), revision.joins.end());
  outcome.alerts.insert(outcome.alerts.end(), revision.alerts.begin(), revision.alerts.end());
}

Outcome run(const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames,
            const Config& config = {}) {
  Revisit revisit(config);
  Outcome outcome;
  for (const auto& k : key_frames) take(revisit.process({k->pose.image, 0, {k}, {}}), outcome);
  take(revisit.process({std::nullopt, 0, {}, {}}), outcome);
  return outcome;
}

double worst_error(const std::vector<std::shared_ptr<const SettledKeyFrame>>& key_frames,
                   const std::vector<Rigid3>& truth, const Corrections& corrections) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto& pose = key_frames[i]->pose;
    const Rigid3 found = corrections.at(pose.submap, pose.image) * pose.survey_from_camera;
    worst = std::max(worst, (found.translation - truth[i].translation).norm());
  }
  return worst;
}

TEST(Revisit, KnownGroundTakesTheDriftOut) {
  Seabed seabed;
  const auto way = two_lanes();
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    key_frames.push_back(seabed.key_frame(2 * i, 0, way[i], drift(i)));
  }
  const Outcome outcome = run(key_frames);
  EXPECT_GT(worst_error(key_frames, way, {}), 0.1);
  // The first camera and the distance of the farthest hold the frame: of the drift's scale what the
  // farthest key frame had remains. Noise of 0.3 px is 1.5 mm on the ground, and 100 points see it.
  Similarity3 gauge = drift(0);
  double farthest = 0;
  const Rigid3 home = way[0].inverse();
  for (std::size_t i = 0; i < way.size(); ++i) {
    const Vector3d live = (drift(0) * way[0]).inverse() * (drift(i) * way[i]).translation;
    if (live.norm() > farthest) {
      farthest = live.norm();
      gauge.scale = farthest / (home * way[i].translation).norm();
    }
  }
  double worst = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const auto& pose = key_frames[i]->pose;
    const Rigid3 found = outcome.corrections.at(0, pose.image) * pose.survey_from_camera;
    const Vector3d expected = way[0] * (gauge.scale * (home * way[i].translation));
    worst = std::max(worst, (found.translation - expected).norm());
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_TRUE(outcome.joins.empty());
}

TEST(Revisit, ALaterSubmapIsJoinedWhereItsGroundIsKnown) {
  Seabed seabed;
  const auto way = two_lanes();
  const Similarity3 elsewhere{
      0.8, {Eigen::Quaterniond(Eigen::AngleAxisd(1, Vector3d::UnitZ())), {10, 4, 0.5}}};
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool later = i >= 14;
    key_frames.push_back(
        seabed.key_frame(i, later ? 1 : 0, way[i], later ? elsewhere : Similarity3()));
  }
  const Outcome outcome = run(key_frames);
  ASSERT_EQ(outcome.joins.size(), 1u);
  EXPECT_EQ(outcome.joins[0].submap, 1u);
  EXPECT_EQ(outcome.joins[0].to, 0u);
  EXPECT_GE(outcome.joins[0].image, 14u);
  EXPECT_LT(outcome.joins[0].seen_by, 14u);
  ASSERT_EQ(outcome.alerts.size(), 1u);
  EXPECT_EQ(outcome.alerts[0].kind, AlertKind::submap_joined);
  EXPECT_LT(worst_error(key_frames, way, outcome.corrections), 0.02);
}

// A gauge's own error is the same in both: the map is no surer than the better one.
TEST(Revisit, JoinedSubmapsAreAsLargeAsTheirMeasuresSayAndAsSureAsTheBest) {
  constexpr double kTrue = 2;  // metres per unit of the first sub-map
  constexpr double kSecond = 0.8;
  Seabed seabed;
  const auto way = two_lanes();
  const Similarity3 elsewhere{kSecond, {Eigen::Quaterniond::Identity(), {10, 4, 0.5}}};
  Revisit revisit{Config{}};
  Revision last;
  Corrections corrections;
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool later = i >= 14;
    key_frames.push_back(
        seabed.key_frame(i, later ? 1 : 0, way[i], later ? elsewhere : Similarity3()));
    const Revision revision = revisit.process({i, 0, {key_frames.back()}, {}});
    for (const auto& c : revision.corrections) corrections.add(c);
  }
  last = revisit.process({std::nullopt,
                          0,
                          {},
                          {{0, kTrue, {ScaleSource::altitude, 0.02}},
                           {1, kTrue / kSecond, {ScaleSource::altitude, 0.03}}}});
  for (const auto& c : last.corrections) corrections.add(c);
  ASSERT_EQ(last.scales.size(), 2u);
  for (const auto& [submap, scale] : last.scales) {
    EXPECT_EQ(scale.source, ScaleSource::altitude);
    EXPECT_DOUBLE_EQ(scale.sigma, 0.02);
  }
  const auto placed = [&](std::size_t i) {
    const auto& pose = key_frames[i]->pose;
    return Vector3d(
        (corrections.at(pose.submap, pose.image) * pose.survey_from_camera).translation);
  };
  const double length = (placed(0) - placed(20)).norm();
  EXPECT_NEAR(length / (way[0].translation - way[20].translation).norm(), kTrue, 0.01 * kTrue);
}

// Without an AHRS the vertical of a sub-map is the normal of its first ground.
TEST(Revisit, SubmapsMayTiltUnlessTheirVerticalsAreMeasured) {
  const auto way = two_lanes();
  const Similarity3 tilted{
      0.8, {Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Vector3d::UnitX())), {10, 4, 0.5}}};
  const auto outcome_with = [&](SurveyAxes axes) {
    Seabed seabed;
    std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const bool later = i >= 14;
      SettledKeyFrame key_frame =
          *seabed.key_frame(i, later ? 1 : 0, way[i], later ? tilted : Similarity3());
      key_frame.axes = axes;
      key_frames.push_back(std::make_shared<SettledKeyFrame>(std::move(key_frame)));
    }
    return run(key_frames);
  };
  EXPECT_EQ(outcome_with(SurveyAxes::first_plane).joins.size(), 1u);
  EXPECT_TRUE(outcome_with(SurveyAxes::attitude).joins.empty());
}

// It saw its own ground again shortly before: that map is no more when the graph is adjusted.
TEST(Revisit, ASubmapIsJoinedThatWasAboutToBeAdjusted) {
  Seabed seabed;
  std::vector<Rigid3> way;
  for (int i = 0; i < 9; ++i) way.push_back(looking_down(0.3 * i, 0, 1.5, 0, 0.03));
  for (int i = 0; i < 9; ++i) way.push_back(looking_down(0.3 * i, 3, 1.5, 0, 0.03));
  for (int i = 0; i < 9; ++i) way.push_back(looking_down(2.4 - 0.3 * i, 2.6, 1.5, M_PI, 0.03));
  for (int i = 1; i < 9; ++i) way.push_back(looking_down(0, 2.6 - 0.3 * i, 1.5, M_PI, 0.03));
  const Similarity3 elsewhere{0.8, {Eigen::Quaterniond::Identity(), {10, 4, 0.5}}};
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool later = i >= 9;
    key_frames.push_back(
        seabed.key_frame(i, later ? 1 : 0, way[i], later ? elsewhere : Similarity3()));
  }
  const Outcome outcome = run(key_frames);
  ASSERT_EQ(outcome.joins.size(), 1u);
  EXPECT_LT(worst_error(key_frames, way, outcome.corrections), 0.03);
}

// On ground whose corners are never found again: their descriptors are noise.
std::shared_ptr<const SettledKeyFrame> dim_key_frame(const odometry::Ground& ground,
                                                     std::uint64_t image, std::uint32_t submap,
                                                     const Rigid3& true_from_camera,
                                                     const Similarity3& live_from_true) {
  static const auto rig = std::make_shared<const CameraRig>(odometry::small_rig());
  auto result = std::make_shared<SettledKeyFrame>();
  result->rig = rig;
  result->pose.image = image;
  result->pose.submap = submap;
  result->pose.key_frame = true;
  result->pose.survey_from_camera = live_from_true * true_from_camera;
  const auto seed = static_cast<unsigned>(image);
  result->picture = image_io::encode_jpeg(ground.image(rig->left, true_from_camera, seed), 90);
  cv::RNG random(image);
  for (std::uint64_t i = 0; i < 80; ++i) {
    const Eigen::Vector2d pixel(random.uniform(5., 315.), random.uniform(5., 235.));
    const Eigen::Vector2d ray = *rig->left.unproject(pixel);
    const Vector3d along = true_from_camera.rotation * ray.homogeneous();
    const Vector3d x =
        true_from_camera.translation - true_from_camera.translation.z() / along.z() * along;
    result->observations.push_back(
        {1'000'000 * submap + 1000 * image + i, ray, std::nullopt, live_from_true * x});
    result->features.pixels.push_back(pixel);
    result->features.rays.push_back(ray);
  }
  result->features.descriptors.create(80, 32, CV_8U);
  random.fill(result->features.descriptors, cv::RNG::UNIFORM, 0, 256);
  return result;
}

TEST(Revisit, BlobsJoinSubmapsWhoseCornersAreNotFoundAgain) {
  const odometry::Ground ground;
  const Similarity3 elsewhere{
      0.8, {Eigen::Quaterniond(Eigen::AngleAxisd(1, Vector3d::UnitZ())), {10, 4, 0.5}}};
  std::vector<Rigid3> way;
  for (int i = 0; i < 6; ++i) way.push_back(looking_down(0.5 * i, -0.2, 1.5, 0, 0.03));
  for (int i = 0; i < 8; ++i) way.push_back(looking_down(2.5 - 0.3 * i, 0.2, 1.5, M_PI, 0.03));
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool later = i >= 6;
    key_frames.push_back(
        dim_key_frame(ground, i, later ? 1 : 0, way[i], later ? elsewhere : Similarity3()));
  }
  const Outcome outcome = run(key_frames);
  ASSERT_EQ(outcome.joins.size(), 1u);
  // A blob is good to about a pixel, which is 5 mm on the ground.
  EXPECT_LT(worst_error(key_frames, way, outcome.corrections), 0.03);
}

// Of a long first map the key frames take turns: of a short second one few are compared on the way.
TEST(Revisit, WhatIsApartAtTheEndIsComparedAllOver) {
  const odometry::Ground ground;
  const Similarity3 elsewhere{
      0.8, {Eigen::Quaterniond(Eigen::AngleAxisd(1, Vector3d::UnitZ())), {10, 4, 0.5}}};
  std::vector<Rigid3> way;
  for (int i = 0; i < 15; ++i) way.push_back(looking_down(0.7 * i, -0.2, 1.5, 0, 0.03));
  for (int i = 0; i < 3; ++i) way.push_back(looking_down(0.7 - 0.3 * i, 0.2, 1.5, M_PI, 0.03));
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool later = i >= 15;
    key_frames.push_back(
        dim_key_frame(ground, i, later ? 1 : 0, way[i], later ? elsewhere : Similarity3()));
  }
  Revisit revisit(Config{});
  Outcome on_the_way, at_the_end;
  for (const auto& k : key_frames) take(revisit.process({k->pose.image, 0, {k}, {}}), on_the_way);
  take(revisit.process({std::nullopt, 0, {}, {}}), at_the_end);
  EXPECT_TRUE(on_the_way.joins.empty());
  EXPECT_EQ(at_the_end.joins.size(), 1u);
}

TEST(Revisit, BlobsOfOtherGroundJoinNothing) {
  const odometry::Ground ground(1), other(2);
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Rigid3 pose = looking_down(0.4 * static_cast<double>(i % 6), 0, 1.5, 0, 0.03);
    key_frames.push_back(dim_key_frame(i < 6 ? ground : other, i, i < 6 ? 0 : 1, pose, {}));
  }
  EXPECT_TRUE(run(key_frames).joins.empty());
}

// A sub-map along y = -2 and one along y = 3.5, which odometry believes to be elsewhere.
std::vector<std::shared_ptr<const SettledKeyFrame>> two_submaps_apart(
    Seabed& seabed, const Similarity3& elsewhere) {
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const bool later = i >= 10;
    const Rigid3 pose = looking_down(0.3 * static_cast<double>(i % 10), later ? 3.5 : -2, 1.5);
    key_frames.push_back(
        seabed.key_frame(i, later ? 1 : 0, pose, later ? elsewhere : Similarity3()));
  }
  return key_frames;
}

TEST(Revisit, SubmapsOfOtherGroundStayApart) {
  Seabed seabed;
  // Dead reckoning put it onto the first map's ground.
  const Similarity3 wrong{1, {Eigen::Quaterniond::Identity(), {0, -5.5, 0}}};
  const Outcome outcome = run(two_submaps_apart(seabed, wrong));
  EXPECT_TRUE(outcome.joins.empty());
  EXPECT_TRUE(outcome.corrections.empty());
}

// A print or a tile of 0.6 by 0.7 m in images of 1.6 by 1.2 m.
TEST(Link, NeedsTheCommonGroundAndNotOnlyAThingOnIt) {
  Seabed seabed;
  seabed.repeat(1, -2.35, 0.6, 0.7, 0, 5.5);
  std::vector<Node> nodes;
  for (const auto& pose :
       {looking_down(1.3, -2, 1.5), looking_down(1.6, -1.9, 1.5), looking_down(1.3, 3.5, 1.5)}) {
    nodes.emplace_back(*seabed.key_frame(nodes.size(), 0, pose, {}));
  }
  EXPECT_TRUE(link(nodes, 0, 1));
  EXPECT_FALSE(link(nodes, 0, 2));
}

TEST(Revisit, SwitchedOffItSaysNothing) {
  Seabed seabed;
  const auto way = two_lanes();
  std::vector<std::shared_ptr<const SettledKeyFrame>> key_frames;
  for (std::size_t i = 0; i < way.size(); ++i) {
    key_frames.push_back(seabed.key_frame(i, 0, way[i], drift(i)));
  }
  Config off;
  off.enabled = false;
  EXPECT_TRUE(run(key_frames, off).corrections.empty());
}

TEST(Revisit, RefusesSettingsOutOfRange) {
  Config config;
  config.gap = 1;
  EXPECT_THROW(config.check(), InputError);
}

// What another lens than the calibrated one makes of the rays.
std::shared_ptr<const SettledKeyFrame> bent(const SettledKeyFrame& key_frame) {
  constexpr double kK1 = 0.05;
  auto result = std::make_shared<SettledKeyFrame>(key_frame);
  for (auto& seen : result->observations) seen.ray *= 1 + kK1 * seen.ray.squaredNorm();
  return result;
}

TEST(Revisit, TellsOfACalibrationThatDoesNotFitWhetherItLooksForKnownGroundOrNot) {
  Seabed seabed;
  std::vector<std::shared_ptr<const SettledKeyFrame>> good, wrong;
  // Turning: a straight lane takes another lens for a bend of the ground.
  for (int i = 0; i < 12; ++i) {
    const Rigid3 pose = looking_down(0.2 * i, 0, 1.5 + 0.1 * (i % 2), 0.8 * i, 0.1 * (i % 3));
    good.push_back(seabed.key_frame(good.size(), 0, pose, {}));
    wrong.push_back(bent(*good.back()));
  }
  Config config;
  const auto suspected = [&](const auto& key_frames) {
    return std::ranges::any_of(run(key_frames, config).alerts, [](const Alert& alert) {
      return alert.kind == AlertKind::calibration_suspect;
    });
  };
  for (const bool enabled : {true, false}) {
    config.enabled = enabled;
    config.check_calibration = true;
    EXPECT_TRUE(suspected(wrong)) << enabled;
    EXPECT_FALSE(suspected(good)) << enabled;
    config.check_calibration = false;
    EXPECT_FALSE(suspected(wrong)) << enabled;
  }
}

}  // namespace
}  // namespace nadir::revisit
