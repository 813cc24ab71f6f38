// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "pairing.hpp"

#include <gtest/gtest.h>

namespace nadir::capture {
namespace {

constexpr Time kMillisecond = 1'000'000;
constexpr Time kPeriod = 100 * kMillisecond;
using Side = Pairing::Side;

Picture at(Time time) {
  Picture picture;
  picture.time = time;
  return picture;
}

TEST(Pairing, TakesPicturesOfOneMomentTogether) {
  Pairing pairing;
  for (Time t = kPeriod; t <= 3 * kPeriod; t += kPeriod) {
    pairing.add(Side::right, at(t + 2 * kMillisecond));
    EXPECT_FALSE(pairing.take(kPeriod));
    pairing.add(Side::left, at(t));
    const auto pair = pairing.take(kPeriod);
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->left.time, t);
    EXPECT_EQ(pair->right.time, t + 2 * kMillisecond);
  }
  EXPECT_EQ(pairing.take_unpaired(), 0u);
}

TEST(Pairing, GivesUpALeftPictureWhoseRightOneIsMissing) {
  Pairing pairing;
  pairing.add(Side::left, at(kPeriod));
  pairing.add(Side::left, at(2 * kPeriod));
  pairing.add(Side::right, at(2 * kPeriod - kMillisecond));
  const auto pair = pairing.take(kPeriod);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->left.time, 2 * kPeriod);
  EXPECT_EQ(pairing.take_unpaired(), 1u);
  EXPECT_EQ(pairing.take_unpaired(), 0u);
}

TEST(Pairing, NeverTakesPicturesHalfAPeriodApart) {
  Pairing pairing;
  for (int i = 1; i <= 10; ++i) {
    pairing.add(Side::left, at(i * kPeriod));
    pairing.add(Side::right, at(i * kPeriod + kPeriod / 2));
    EXPECT_FALSE(pairing.take(kPeriod));
  }
}

// Drivers have few buffers: a camera whose partner is gone must get its own back.
TEST(Pairing, HoldsFewPicturesWhileTheOtherCameraIsSilent) {
  Pairing pairing;
  const auto buffer = std::make_shared<int>();
  for (int i = 1; i <= 50; ++i) {
    Picture picture = at(i * kPeriod);
    picture.hold = buffer;
    pairing.add(Side::left, std::move(picture));
    EXPECT_FALSE(pairing.take(kPeriod));
    EXPECT_LE(buffer.use_count(), 3);
  }
  EXPECT_EQ(pairing.take_unpaired(), 48u);
}

TEST(Pairing, TellsTheSkewOfMostPairs) {
  Pairing pairing;
  for (int i = 1; i <= 20; ++i) {
    EXPECT_FALSE(pairing.skew());
    const Time skew = i % 5 == 0 ? 30 * kMillisecond : -4 * kMillisecond;  // some are late
    pairing.add(Side::left, at(i * kPeriod));
    pairing.add(Side::right, at(i * kPeriod + skew));
    ASSERT_TRUE(pairing.take(kPeriod));
  }
  EXPECT_EQ(pairing.skew(), -4 * kMillisecond);
}

}  // namespace
}  // namespace nadir::capture
