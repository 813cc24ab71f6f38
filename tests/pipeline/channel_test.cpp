// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/pipeline/channel.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "nadir/core/check.hpp"

namespace nadir::pipeline {
namespace {

using namespace std::chrono_literals;

TEST(Channel, RefusesToBeMadeWithoutRoom) {
  EXPECT_THROW(Channel<int>(0, WhenFull::wait), ContractError);
}

TEST(Channel, DeliversInOrderThenTheEndForEver) {
  Channel<int> channel(3, WhenFull::wait);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(channel.push(i));
  EXPECT_EQ(channel.depth(), 3u);
  channel.close();
  EXPECT_FALSE(channel.ended());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(channel.pop(), i);
  EXPECT_TRUE(channel.ended());
  EXPECT_EQ(channel.pop(), std::nullopt);
  EXPECT_EQ(channel.pop(), std::nullopt);
}

TEST(Channel, ClosesWithoutBlockingWhileFull) {
  Channel<int> channel(1, WhenFull::wait);
  channel.push(7);
  channel.close();
  channel.close();
  EXPECT_EQ(channel.pop(), 7);
  EXPECT_EQ(channel.pop(), std::nullopt);
}

TEST(Channel, IsNotPushedIntoAfterItsEnd) {
  Channel<int> channel(1, WhenFull::wait);
  channel.close();
  EXPECT_THROW(channel.push(1), ContractError);
}

TEST(Channel, CountsWhatItDropsWhenFull) {
  Channel<int> channel(2, WhenFull::drop);
  EXPECT_TRUE(channel.push(0));
  EXPECT_TRUE(channel.push(1));
  EXPECT_FALSE(channel.push(2));
  EXPECT_FALSE(channel.push(3));
  EXPECT_EQ(channel.dropped(), 2u);
  EXPECT_EQ(channel.pop(), 0);
  EXPECT_TRUE(channel.push(4));
  channel.close();
  EXPECT_EQ(channel.pop(), 1);
  EXPECT_EQ(channel.pop(), 4);
  EXPECT_EQ(channel.pop(), std::nullopt);
  EXPECT_EQ(channel.accepted(), 3u);
}

TEST(Channel, CarriesWhatCanOnlyBeMoved) {
  Channel<std::unique_ptr<int>> channel(1, WhenFull::wait);
  channel.push(std::make_unique<int>(5));
  const auto item = channel.pop();
  ASSERT_TRUE(item.has_value());
  EXPECT_EQ(**item, 5);
}

TEST(Channel, KeepsNoItemItHasDelivered) {
  Channel<std::shared_ptr<int>> channel(4, WhenFull::wait);
  const auto image = std::make_shared<int>(1);
  channel.push(image);
  channel.pop().reset();
  EXPECT_EQ(image.use_count(), 1);
}

TEST(Channel, AbandonedFreesAProducerThatWaits) {
  Channel<int> channel(1, WhenFull::wait);
  channel.push(0);
  bool taken = true;
  std::thread producer([&] { taken = channel.push(1); });
  std::this_thread::sleep_for(20ms);
  channel.abandon();
  producer.join();
  EXPECT_FALSE(taken);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(channel.push(i));
}

TEST(Channel, AbandonedFreesAConsumerThatWaits) {
  Channel<int> channel(1, WhenFull::wait);
  std::optional<int> item = 1;
  std::thread consumer([&] { item = channel.pop(); });
  std::this_thread::sleep_for(20ms);
  channel.abandon();
  consumer.join();
  EXPECT_EQ(item, std::nullopt);
}

class ChannelOfCapacity : public testing::TestWithParam<std::size_t> {};

TEST_P(ChannelOfCapacity, LosesAndReordersNothingBetweenThreads) {
  constexpr std::uint64_t kItems = 30'000;
  Channel<std::uint64_t> channel(GetParam(), WhenFull::wait);
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < kItems; ++i) channel.push(i);
    channel.close();
  });
  std::uint64_t next = 0;
  while (const auto item = channel.pop()) {
    if (*item != next) break;
    ++next;
  }
  producer.join();
  EXPECT_EQ(next, kItems);
}

TEST_P(ChannelOfCapacity, DeliversOrCountsEveryItemBetweenThreads) {
  constexpr std::uint64_t kItems = 30'000;
  Channel<std::uint64_t> channel(GetParam(), WhenFull::drop);
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < kItems; ++i) channel.push(i);
    channel.close();
  });
  std::uint64_t received = 0, last = 0;
  bool ordered = true;
  while (const auto item = channel.pop()) {
    ordered = ordered && (received == 0 || *item > last);
    last = *item;
    ++received;
  }
  producer.join();
  EXPECT_TRUE(ordered);
  EXPECT_EQ(received + channel.dropped(), kItems);
}

TEST_P(ChannelOfCapacity, CanBeAbandonedAtAnyMoment) {
  for (int round = 0; round < 300; ++round) {
    Channel<std::unique_ptr<int>> channel(GetParam(), WhenFull::wait);
    std::thread producer([&] {
      while (channel.push(std::make_unique<int>(round))) {
      }
    });
    for (int i = 0; i < round % 7; ++i) channel.pop();
    channel.abandon();
    EXPECT_EQ(channel.pop(), std::nullopt);
    producer.join();
  }
}

INSTANTIATE_TEST_SUITE_P(Small, ChannelOfCapacity, testing::Values(1, 2, 3, 64));

}  // namespace
}  // namespace nadir::pipeline
