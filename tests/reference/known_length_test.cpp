// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/reference/known_length.hpp"

#include <gtest/gtest.h>

#include "nadir/core/check.hpp"
#include "reference/flat_ground.hpp"

namespace nadir::reference {
namespace {

TEST(KnownLength, IsReadAsImagePixelsAndMetres) {
  const auto length = parse_known_length("12 310.5 220 640 230 0.5");
  ASSERT_TRUE(length);
  EXPECT_EQ(length->image, 12u);
  EXPECT_EQ(length->pixels[0], Eigen::Vector2d(310.5, 220));
  EXPECT_EQ(length->pixels[1], Eigen::Vector2d(640, 230));
  EXPECT_EQ(length->metres, 0.5);
  EXPECT_FALSE(parse_known_length(""));
}

TEST(KnownLength, WrongTextIsRefused) {
  for (const char* wrong :
       {"12 310 220 640 230", "12 310 220 640 230 0.5 m", "a 310 220 640 230 0.5",
        "12 310 220 640 230 0", "12 310 220 640 230 -1", "12 310 220 311 220 0.5",
        "-1 310 220 640 230 0.5", "12 nan 220 640 230 0.5"}) {
    EXPECT_THROW(parse_known_length(wrong), InputError) << wrong;
  }
}

// Of 500 px focal length, 2 m above the ground: 250 px are a metre.
TEST(KnownLength, ScalesTheMapOfItsImage) {
  constexpr double kRatio = 2.5;
  FlatGround ground{kRatio};
  TypedScale scale(*parse_known_length("1 219.5 239.5 419.5 239.5 0.8"));
  for (int i = 0; i < 3; ++i) scale.observe(ground.orientation(ground.image(0.1 * i, 2)));
  const auto measure = scale.estimate(0);
  ASSERT_TRUE(measure);
  EXPECT_NEAR(measure->ratio, kRatio, 1e-6);
  EXPECT_NEAR(measure->sigma, 0.0092, 0.0002);  // a pixel at either end of 200, ruler and relief
  EXPECT_FALSE(scale.estimate(1));
  EXPECT_EQ(scale.fault(), "");
}

TEST(KnownLength, SaysWhyItGivesNoScale) {
  FlatGround ground;
  TypedScale absent(*parse_known_length("7 219 239 419 239 0.8"));
  TypedScale outside(*parse_known_length("1 1219 239 1419 239 0.8"));
  TypedScale lost(*parse_known_length("2 219 239 419 239 0.8"));
  for (int i = 0; i < 3; ++i) {
    Orientation orientation = ground.orientation(ground.image(0.1 * i, 2));
    if (i == 2) orientation.poses.clear();
    for (TypedScale* scale : {&absent, &outside, &lost}) scale->observe(orientation);
  }
  EXPECT_EQ(absent.fault(), "image 7 was not there");
  EXPECT_EQ(outside.fault(), "its ends in image 1 are not among tie points");
  EXPECT_EQ(lost.fault(), "image 2 has no pose");
}

}  // namespace
}  // namespace nadir::reference
