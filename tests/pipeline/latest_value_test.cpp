// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/latest_value.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace nadir::pipeline {
namespace {

TEST(LatestValue, GivesTheNewestOnceAndCountsTheOthers) {
  LatestValue<int> value;
  EXPECT_EQ(value.try_take(), std::nullopt);
  for (int i = 0; i < 3; ++i) value.publish(i);
  EXPECT_EQ(value.try_take(), 2);
  EXPECT_EQ(value.try_take(), std::nullopt);
  EXPECT_EQ(value.superseded(), 2u);
}

TEST(LatestValue, GivesTheLastValueBeforeTheEnd) {
  LatestValue<std::unique_ptr<int>> value;
  value.publish(std::make_unique<int>(3));
  value.close();
  EXPECT_EQ(*value.take().value(), 3);
  EXPECT_EQ(value.take(), std::nullopt);
  EXPECT_EQ(value.take(), std::nullopt);
  EXPECT_EQ(value.try_take(), std::nullopt);
}

TEST(LatestValue, FreesWhatNobodyTook) {
  const auto image = std::make_shared<int>(1);
  {
    LatestValue<std::shared_ptr<int>> value;
    value.publish(image);
    value.publish(image);
    EXPECT_EQ(image.use_count(), 2);
  }
  EXPECT_EQ(image.use_count(), 1);
}

TEST(LatestValue, OnlyMovesForwardAndAlwaysReachesTheLast) {
  constexpr int kValues = 100'000;
  LatestValue<int> value;
  std::thread producer([&] {
    for (int i = 1; i <= kValues; ++i) value.publish(i);
    value.close();
  });
  int last = 0, taken = 0;
  bool forward = true;
  while (const auto next = value.take()) {
    forward = forward && *next > last;
    last = *next;
    ++taken;
  }
  producer.join();
  EXPECT_TRUE(forward);
  EXPECT_EQ(last, kValues);
  EXPECT_EQ(taken + static_cast<int>(value.superseded()), kValues);
}

}  // namespace
}  // namespace nadir::pipeline
