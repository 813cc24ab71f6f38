// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/odometry/pair_fit.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "odometry/film.hpp"

namespace nadir::odometry {
namespace {

// The right image moved down by so many pixels.
Frame pair_with(double down_px) {
  Frame frame = *film(small_pair(), swimming_path(1))[0]->frame;
  const cv::Matx23d shift(1, 0, 0, 0, 1, down_px);
  cv::warpAffine(frame.right, frame.right, shift, frame.right.size(), cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  return frame;
}

TEST(PairFit, MeasuresTheDistanceFromTheEpipolarLines) {
  // Of a pair side by side they are the rows; corners are good to 0.6 px.
  EXPECT_LT(pair_fit(pair_with(0)).epipolar_px, 0.6);
  EXPECT_NEAR(pair_fit(pair_with(2)).epipolar_px, 2, 0.4);
  EXPECT_NEAR(pair_fit(pair_with(-6)).epipolar_px, 6, 0.4);
}

TEST(PairFit, CountsWhatTheCalibrationAllows) {
  const PairFit good = pair_fit(pair_with(0)), bad = pair_fit(pair_with(12));
  EXPECT_GT(good.matches, kEnoughMatches);
  EXPECT_GT(good.allowed, 0.9 * good.matches);
  EXPECT_LT(bad.allowed, 0.2 * bad.matches);
}

TEST(PairFit, SeesThatTheRightImageIsBlank) {
  Frame frame = pair_with(0);
  EXPECT_FALSE(pair_fit(frame).right_blank);
  frame.right = cv::Mat::zeros(frame.right.size(), CV_8U);
  const PairFit fit = pair_fit(frame);
  EXPECT_TRUE(fit.right_blank);
  EXPECT_EQ(fit.matches, 0);
}

}  // namespace
}  // namespace nadir::odometry
