// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "light.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>

namespace nadir::mosaic2d {
namespace {

// Bright in the middle, a third at the corners; `offset` shifts the texture below.
cv::Mat lit_by_lamps(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> albedo(80, 160);
  cv::Mat image(180, 240, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double r2 = std::pow((u - 120) / 120.0, 2) + std::pow((v - 90) / 90.0, 2);
      const double value = albedo(random) / (1 + r2);
      image.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<std::uint8_t>(value));
    }
  }
  return image;
}

double mean_at(const cv::Mat& image, int u, int v) {
  return cv::mean(image(cv::Rect(u, v, 30, 30)))[0];
}

TEST(LampPattern, FlattensWhatStaysWithTheCamera) {
  LampPattern lamps;
  cv::Mat flat;
  for (unsigned i = 0; i < 20; ++i) flat = lamps.flatten(lit_by_lamps(i));
  const double middle = mean_at(flat, 105, 75), corner = mean_at(flat, 0, 0);
  EXPECT_NEAR(corner / middle, 1, 0.12);
  EXPECT_LT(mean_at(lit_by_lamps(0), 0, 0) / mean_at(lit_by_lamps(0), 105, 75), 0.5);
}

TEST(LampPattern, KeepsAnObjectThatPassesOnce) {
  LampPattern lamps;
  for (unsigned i = 0; i < 40; ++i) lamps.flatten(lit_by_lamps(i));
  cv::Mat stone = lit_by_lamps(41);
  stone(cv::Rect(60, 60, 50, 50)) *= 0.5;
  const cv::Mat flat = lamps.flatten(stone);
  EXPECT_NEAR(mean_at(flat, 70, 70) / mean_at(flat, 130, 70), 0.5, 0.07);
}

TEST(LampPattern, LeavesAnEvenImageAlone) {
  const cv::Mat even(120, 160, CV_8UC3, cv::Scalar(30, 60, 90));
  const cv::Mat flat = LampPattern().flatten(even);
  EXPECT_LE(cv::norm(flat, even, cv::NORM_INF), 1);
}

TEST(LampPattern, FollowsAChangeOfImageSizeAndStandsBlackAndWhite) {
  LampPattern lamps;
  lamps.flatten(lit_by_lamps(1));
  for (int grey : {0, 255}) {
    const cv::Mat image(90, 160, CV_8UC3, cv::Scalar::all(grey));
    EXPECT_EQ(lamps.flatten(image).size(), image.size());
  }
}

TEST(ApplyGain, ScalesColoursAndKeepsAlpha) {
  cv::Mat image(1, 3, CV_8UC4, cv::Scalar(100, 100, 200, 255));
  image.at<cv::Vec4b>(0, 2) = {};
  apply_gain(image, {1.0, 1.5, 1.9});
  EXPECT_EQ(image.at<cv::Vec4b>(0, 0), cv::Vec4b(100, 150, 255, 255));
  EXPECT_EQ(image.at<cv::Vec4b>(0, 2), cv::Vec4b());
}

}  // namespace
}  // namespace nadir::mosaic2d
