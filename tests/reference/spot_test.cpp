// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "spot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace nadir::reference {
namespace {

using Eigen::Vector2d;

constexpr double kSigma = 1.8, kAmplitude = 120, kBackground = 30;
const Vector2d kSlope(1.5, -0.8);  // of a lamp's light
const Vector2d kCentre(20.37, 19.81);

cv::Mat1f lit(const Vector2d& centre, double amplitude, double noise) {
  cv::Mat1f image(40, 40);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Vector2d from = Vector2d(x, y) - centre;
      image(y, x) =
          static_cast<float>(kBackground + kSlope.dot(from) +
                             amplitude * std::exp(-from.squaredNorm() / (2 * kSigma * kSigma)));
    }
  }
  cv::Mat1f disturbed(image.size());
  cv::RNG random(7);
  random.fill(disturbed, cv::RNG::NORMAL, 0, noise);
  image += disturbed;
  return image;
}

cv::Mat1b nothing_clipped(const cv::Mat1f& image) { return {image.size(), 0}; }

TEST(Spot, IsFoundOnASlopingBackground) {
  const cv::Mat1f image = lit(kCentre, kAmplitude, 0);
  const auto spot = fit_spot(image, nothing_clipped(image), {21, 19}, 8);
  ASSERT_TRUE(spot);
  EXPECT_LT((spot->centre - kCentre).norm(), 1e-3);
  EXPECT_NEAR(spot->sigma, kSigma, 1e-3);
  EXPECT_NEAR(spot->amplitude, kAmplitude, 0.1);
  EXPECT_NEAR(spot->background, kBackground, 0.1);
  EXPECT_LT((spot->slope - kSlope).norm(), 1e-2);
}

TEST(Spot, SaysHowGoodItsCentreIs) {
  const cv::Mat1f image = lit(kCentre, kAmplitude, 4);
  const auto spot = fit_spot(image, nothing_clipped(image), {20, 20}, 8);
  ASSERT_TRUE(spot);
  EXPECT_NEAR(spot->rms, 4, 0.8);
  // One sample's noise over the slope of a bell: sigma_noise / (amplitude sqrt(pi / 2)) = 0.027 px.
  EXPECT_NEAR(spot->sigma_centre, 0.027, 0.01);
  EXPECT_LT((spot->centre - kCentre).norm(), 4 * spot->sigma_centre);
}

// Clipped beside its centre, as where a lamp's light is added: read as it is the top looks
// displaced.
TEST(Spot, ClippedTopDoesNotMoveIt) {
  cv::Mat1f image = lit(kCentre, kAmplitude, 0);
  cv::Mat1b clipped = nothing_clipped(image);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float limit = static_cast<float>(70 + 8 * (x - 20));
      if (image(y, x) <= limit || std::abs(x - 20) > 4) continue;
      image(y, x) = limit;
      clipped(y, x) = 255;
    }
  }
  const auto naive = fit_spot(image, nothing_clipped(image), {20, 20}, 8);
  const auto aware = fit_spot(image, clipped, {20, 20}, 8);
  ASSERT_TRUE(naive && aware);
  EXPECT_GT((naive->centre - kCentre).norm(), 0.2);
  EXPECT_LT((aware->centre - kCentre).norm(), 0.01);
}

TEST(Spot, NoneWhereThereIsNone) {
  const cv::Mat1f dark = lit(kCentre, -kAmplitude, 0);
  EXPECT_FALSE(fit_spot(dark, nothing_clipped(dark), {20, 20}, 8));
  const cv::Mat1f image = lit(kCentre, kAmplitude, 0);
  EXPECT_FALSE(fit_spot(image, nothing_clipped(image), {28, 20}, 8));  // elsewhere
  EXPECT_FALSE(fit_spot(image, nothing_clipped(image), {5, 20}, 8));   // over the border
}

}  // namespace
}  // namespace nadir::reference
