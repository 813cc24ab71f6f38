// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "features.hpp"

#include <gtest/gtest.h>

#include "matching.hpp"
#include "odometry/ground.hpp"

namespace nadir::odometry {
namespace {

cv::Mat seabed(double x, double yaw = 0) {
  static const Ground ground(9);
  return ground.image(small_rig().left, looking_down(x, 0, 1, yaw), 2);
}

TEST(Features, CoverTheDimSideOfTheImageToo) {
  cv::Mat image = seabed(0);
  cv::Mat dim = image.colRange(160, 320);
  dim.convertTo(dim, CV_8U, 0.25, 10);
  const Features f = detect_features(image, small_rig().left, 500);
  const auto right =
      std::count_if(f.pixels.begin(), f.pixels.end(), [](const auto& p) { return p.x() > 160; });
  EXPECT_GT(f.size(), 300);
  EXPECT_GT(right, f.size() / 4);
}

TEST(Features, AreNoneOnAnEvenImage) {
  EXPECT_EQ(
      detect_features(cv::Mat(240, 320, CV_8U, cv::Scalar(100)), small_rig().left, 500).size(), 0);
  EXPECT_EQ(
      detect_features(cv::Mat(240, 320, CV_8U, cv::Scalar(255)), small_rig().left, 500).size(), 0);
  EXPECT_EQ(detect_features(cv::Mat(20, 20, CV_8U, cv::Scalar(0)), small_rig().left, 500).size(),
            0);
}

TEST(Features, MatchAcrossATurnAboutTheOpticalAxis) {
  const Features a = detect_features(seabed(0), small_rig().left, 500);
  const Features b = detect_features(seabed(0.1, 0.8), small_rig().left, 500);
  const auto pairs = match_descriptors(a.descriptors, b.descriptors, 0.85);
  const Rigid3 second_from_first = looking_down(0.1, 0, 1, 0.8).inverse() * looking_down(0, 0, 1);
  int right = 0;
  for (const auto& [i, k] : pairs) {
    const Eigen::Vector3d x = second_from_first * a.rays[static_cast<std::size_t>(i)].homogeneous();
    right += (x.hnormalized() - b.rays[static_cast<std::size_t>(k)]).norm() * 300 < 3 ? 1 : 0;
  }
  EXPECT_GT(right, 40);
  EXPECT_GT(right * 2, static_cast<int>(pairs.size()));
}

TEST(Matching, FindsOnlyWhatIsNearTheExpectedPlace) {
  const Features a = detect_features(seabed(0), small_rig().left, 500);
  const auto there = match_near(a.descriptors, a.pixels, a, 3, 30);
  EXPECT_GT(static_cast<int>(there.size()), a.size() * 9 / 10);
  auto elsewhere = a.pixels;
  for (auto& p : elsewhere) p.x() += 5000;
  EXPECT_TRUE(match_near(a.descriptors, elsewhere, a, 3, 30).empty());
  for (auto& p : elsewhere) p.x() = std::nan("");
  EXPECT_TRUE(match_near(a.descriptors, elsewhere, a, 3, 30).empty());
}

TEST(Matching, HasNoPairsWithoutDescriptors) {
  EXPECT_TRUE(match_descriptors(cv::Mat(0, 32, CV_8U), cv::Mat(0, 32, CV_8U), 0.8).empty());
}

}  // namespace
}  // namespace nadir::odometry
