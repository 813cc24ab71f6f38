// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "matching.hpp"

#include <gtest/gtest.h>

#include <bitset>
#include <random>

namespace nadir::odometry {
namespace {

cv::Mat random_descriptors(int count, std::mt19937& random) {
  cv::Mat rows(count, 32, CV_8U);
  for (auto& byte : cv::Mat_<std::uint8_t>(rows)) byte = static_cast<std::uint8_t>(random());
  return rows;
}

// With some bits of each row turned over.
cv::Mat disturbed(const cv::Mat& rows, int bits, std::mt19937& random) {
  cv::Mat result = rows.clone();
  for (int i = 0; i < rows.rows; ++i) {
    for (int k = 0; k < bits; ++k) {
      const unsigned bit = random() % 256;
      result.at<std::uint8_t>(i, static_cast<int>(bit / 8)) ^=
          static_cast<std::uint8_t>(1U << (bit % 8));
    }
  }
  return result;
}

int bits_apart(const cv::Mat& a, int i, const cv::Mat& b, int k) {
  int bits = 0;
  for (int byte = 0; byte < 32; ++byte) {
    const unsigned both = a.at<std::uint8_t>(i, byte) ^ b.at<std::uint8_t>(k, byte);
    bits += static_cast<int>(std::bitset<8>(both).count());
  }
  return bits;
}

// Lowe's ratio test, and of several that want the same feature the nearest, the first of equals.
Pairs by_definition(const cv::Mat& first, const cv::Mat& second, double ratio) {
  std::vector<int> owner(static_cast<std::size_t>(second.rows), -1);
  for (int i = 0; i < first.rows; ++i) {
    std::vector<std::pair<int, int>> all;
    for (int k = 0; k < second.rows; ++k) all.emplace_back(bits_apart(first, i, second, k), k);
    std::sort(all.begin(), all.end());
    if (!(all[0].first < ratio * all[1].first)) continue;
    int& taken = owner[static_cast<std::size_t>(all[0].second)];
    if (taken < 0 || all[0].first < bits_apart(first, taken, second, all[0].second)) taken = i;
  }
  Pairs pairs;
  for (int k = 0; k < second.rows; ++k) {
    if (owner[static_cast<std::size_t>(k)] >= 0)
      pairs.emplace_back(owner[static_cast<std::size_t>(k)], k);
  }
  return pairs;
}

TEST(Matching, FindsTheNearestByDefinition) {
  std::mt19937 random(3);
  const cv::Mat first = random_descriptors(80, random);
  cv::Mat second = disturbed(first, 40, random);
  second.push_back(disturbed(first.rowRange(0, 20), 45, random));  // some features twice
  const Pairs expected = by_definition(first, second, 0.85);
  EXPECT_GT(expected.size(), 50U);
  EXPECT_EQ(match_descriptors(first, second, 0.85), expected);
}

TEST(Matching, TakesPartsOfLargerMatrices) {
  std::mt19937 random(4);
  const cv::Mat first = random_descriptors(40, random);
  cv::Mat wide(40, 64, CV_8U, cv::Scalar(0));
  cv::Mat part = wide.colRange(16, 48);
  disturbed(first, 20, random).copyTo(part);
  EXPECT_EQ(match_descriptors(first, part, 0.85), by_definition(first, part.clone(), 0.85));
}

TEST(Matching, NearAPlaceTakesOnlyWhatIsThere) {
  std::mt19937 random(5);
  const cv::Mat first = random_descriptors(30, random);
  Features second;
  second.descriptors = disturbed(first, 10, random);
  std::vector<Eigen::Vector2d> expected;
  for (int i = 0; i < 30; ++i) {
    second.pixels.emplace_back(40.0 * (i % 6), 40.0 * (i / 6));
    second.rays.emplace_back(0, 0);
    expected.push_back(second.pixels.back() + Eigen::Vector2d(i < 20 ? 3 : 15, 0));
  }
  const Pairs pairs = match_near(first, expected, second, 10, 64);
  ASSERT_EQ(pairs.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(pairs[static_cast<std::size_t>(i)], std::pair(i, i));
}

TEST(Matching, OfNothingIsNothing) {
  std::mt19937 random(6);
  EXPECT_TRUE(match_descriptors(cv::Mat(0, 32, CV_8U), random_descriptors(5, random), 0.8).empty());
  Features none;
  none.descriptors.create(0, 32, CV_8U);
  EXPECT_TRUE(match_near(random_descriptors(1, random), {{5, 5}}, none, 10, 1000).empty());
}

}  // namespace
}  // namespace nadir::odometry
