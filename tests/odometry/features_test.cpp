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

TEST(Blobs, OfOverlappingImagesOfDimUnevenGroundAgreeWithTheGeometry) {
  const Ground ground;
  const CameraRig rig = small_rig();
  const Rigid3 a = looking_down(0, 0, 1), b = looking_down(0.3, 0.1, 1.1, 0.4);
  const auto dim = [&](const Rigid3& pose, unsigned seed) {
    cv::Mat image = ground.image(rig.left, pose, seed);
    for (int row = 0; row < image.rows; ++row) {  // a lamp on one side
      image.row(row) *= 0.25 + 0.35 * row / image.rows;
    }
    return image;
  };
  const Features first = describe_blobs(dim(a, 1), rig.left);
  const Features second = describe_blobs(dim(b, 2), rig.left);
  EXPECT_EQ(first.descriptors.cols, 128);
  const Correspondences matched = correspond(first, second, rig.left);
  ASSERT_GE(matched.pairs.size(), 40u);
  std::vector<double> errors;
  for (const auto& [i, k] : matched.pairs) {
    const Eigen::Vector3d along =
        a.rotation * first.rays[static_cast<std::size_t>(i)].homogeneous();
    const Eigen::Vector3d x = a.translation - a.translation.z() / along.z() * along;
    const auto again = rig.left.project(b.inverse() * x);
    ASSERT_TRUE(again);
    errors.push_back((*again - second.pixels[static_cast<std::size_t>(k)]).norm());
  }
  std::ranges::sort(errors);
  EXPECT_LT(errors[errors.size() / 2], 1.0);
  EXPECT_LT(errors[errors.size() * 9 / 10], 3.0);
}

TEST(Blobs, KnowTheirPlaceInTheWholeImageFromASmallPicture) {
  const Ground ground;
  CameraModel large = small_rig().left;
  large.width *= 4;
  large.height *= 4;
  large.fx *= 4;
  large.fy *= 4;
  large.cx = 4 * large.cx + 1.5;
  large.cy = 4 * large.cy + 1.5;
  const cv::Mat image = ground.image(small_rig().left, looking_down(0, 0, 1), 1);
  const Features whole = describe_blobs(image, small_rig().left);
  const Features small = describe_blobs(image, large);
  ASSERT_EQ(whole.size(), small.size());
  for (std::size_t i = 0; i < whole.rays.size(); ++i) {
    EXPECT_LT((whole.rays[i] - small.rays[i]).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace nadir::odometry
