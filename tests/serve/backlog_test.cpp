// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "backlog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace nadir::serve {
namespace {

using testing::ElementsAre;

constexpr std::size_t kPlenty = 1 << 20;

wire::Bytes record(std::size_t body = 0) {
  wire::Bytes bytes = wire::begin_record(100);
  bytes.resize(bytes.size() + body);
  return bytes;
}

/// Sequences of the next records; CaughtUp as 0.
std::vector<std::uint64_t> take(Backlog& backlog, std::size_t at_most = 1000) {
  std::vector<std::uint64_t> sequences;
  while (sequences.size() < at_most) {
    const SharedBytes bytes = backlog.next();
    if (!bytes) break;
    sequences.push_back(wire::sequence(*bytes));
  }
  return sequences;
}

TEST(Backlog, SendsTheSmallerLiveImageOverAThinLink) {
  RetainedRecords records(kPlenty);
  Backlog backlog(records, 0);
  EXPECT_EQ(take(backlog), std::vector<std::uint64_t>{});
  records.put(Lane::live, 0, record());       // 1
  records.put(Lane::thin_live, 0, record());  // 2
  EXPECT_EQ(wire::sequence(*backlog.next(true)), 2u);
  EXPECT_EQ(backlog.next(true), nullptr);
  EXPECT_EQ(backlog.next(false), nullptr) << "of the same image";
  records.put(Lane::live, 0, record());       // 3
  records.put(Lane::thin_live, 0, record());  // 4
  EXPECT_EQ(wire::sequence(*backlog.next(false)), 3u);
  EXPECT_EQ(backlog.caught_up(), Backlog(records, 0).caught_up()) << "no part of completeness";
}

TEST(Backlog, SendsStateInOrderThenDataNewestFirst) {
  RetainedRecords records(kPlenty);
  records.put(Lane::data, 1, record());   // 1
  records.put(Lane::state, 1, record());  // 2
  records.put(Lane::data, 2, record());   // 3
  records.put(Lane::state, 2, record());  // 4
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog), ElementsAre(2, 4, 3, 1, 0));
  EXPECT_THAT(take(backlog), ElementsAre());
}

TEST(Backlog, SendsOfOneTypeNothingElse) {
  RetainedRecords records(kPlenty);
  records.put(Lane::state, 1, record());                 // 1
  records.put(Lane::state, 2, wire::begin_record(101));  // 2
  records.put(Lane::prompt, 3, wire::begin_record(101));
  records.put(Lane::live, 4, wire::begin_record(101));
  records.put(Lane::state, 5, wire::begin_record(101));  // 5
  Backlog backlog(records, 0, 101);
  EXPECT_THAT(take(backlog), ElementsAre(2, 5));
  records.put(Lane::state, 2, wire::begin_record(101));  // 6
  EXPECT_THAT(take(backlog), ElementsAre(6));
  Backlog later(records, 5, 101);
  EXPECT_THAT(take(later), ElementsAre(6));
}

TEST(Backlog, SkipsWhatWasSuperseded) {
  RetainedRecords records(kPlenty);
  for (int version = 0; version < 10; ++version) records.put(Lane::data, 7, record());
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog), ElementsAre(10, 0));
}

TEST(Backlog, KeepsKeysOfDifferentLanesApart) {
  RetainedRecords records(kPlenty);
  records.put(Lane::data, 7, record());
  records.put(Lane::state, 7, record());
  records.put(Lane::live, 7, record());
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog), ElementsAre(2, 3, 1, 0));
}

TEST(Backlog, SendsOnlyWhatIsNewToAViewerThatReturns) {
  RetainedRecords records(kPlenty);
  for (std::uint64_t key = 1; key <= 4; ++key) records.put(Lane::data, key, record());
  records.put(Lane::data, 1, record());
  Backlog backlog(records, 3);
  EXPECT_THAT(take(backlog), ElementsAre(5, 4, 0));
}

TEST(Backlog, SaysNothingToAViewerThatLacksNothing) {
  RetainedRecords records(kPlenty);
  records.put(Lane::data, 1, record());
  Backlog backlog(records, 1);
  EXPECT_THAT(take(backlog), ElementsAre());
}

TEST(Backlog, ComesBackToWhatItLeftForNewerData) {
  RetainedRecords records(kPlenty);
  for (std::uint64_t key = 1; key <= 4; ++key) records.put(Lane::data, key, record());
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog, 2), ElementsAre(4, 3));
  records.put(Lane::data, 5, record());
  records.put(Lane::data, 6, record());
  EXPECT_THAT(take(backlog, 1), ElementsAre(6));
  records.put(Lane::state, 1, record());  // 7 overtakes
  EXPECT_THAT(take(backlog), ElementsAre(7, 5, 2, 1, 0));
}

TEST(Backlog, SharesALinkBetweenLiveImagesAndData) {
  RetainedRecords records(kPlenty);
  for (std::uint64_t key = 1; key <= 3; ++key) records.put(Lane::data, key, record());
  Backlog backlog(records, 0);
  std::vector<std::uint64_t> sequences;
  for (int i = 0; i < 6; ++i) {
    records.put(Lane::live, 0, record());  // a new image each time: 4, 5 ...
    sequences.push_back(take(backlog, 1).at(0));
  }
  EXPECT_THAT(sequences, ElementsAre(4, 3, 6, 2, 8, 1));
}

TEST(Backlog, GivesWhatIsPromptHalfOfTheLinkHoweverLargeTheOthers) {
  constexpr std::size_t kPrompt = 500, kData = 25'000, kLive = 8'000;
  RetainedRecords records(kPlenty);
  for (std::uint64_t key = 0; key < 20; ++key) records.put(Lane::data, key, record(kData));
  for (std::uint64_t key = 0; key < 200; ++key) records.put(Lane::prompt, key, record(kPrompt));
  Backlog backlog(records, 0);
  std::map<std::size_t, std::size_t> sent;  // bytes of each size of record
  while (sent[kPrompt] < 150 * kPrompt) {
    records.put(Lane::live, 0, record(kLive));
    const std::size_t body = backlog.next()->size() - wire::kHeaderSize;
    sent[body] += body;
  }
  EXPECT_GE(sent[kPrompt] + kData + kLive, sent[kData] + sent[kLive]);
  EXPECT_GE(sent[kData] + kData, sent[kLive]);
  EXPECT_GE(sent[kLive] + kData, sent[kData]);
}

TEST(Backlog, LetsNoLaneSaveUpWhatItDidNotSend) {
  RetainedRecords records(kPlenty);
  for (std::uint64_t key = 0; key < 40; ++key) records.put(Lane::data, key, record(10'000));
  Backlog backlog(records, 0);
  take(backlog, 20);
  for (std::uint64_t key = 0; key < 100; ++key) records.put(Lane::prompt, key, record(1'000));
  const std::vector<std::uint64_t> next = take(backlog, 40);
  EXPECT_EQ(next.front(), 140u) << "the newest of what is prompt";
  const auto data = std::count_if(next.begin(), next.end(), [](auto at) { return at <= 40; });
  EXPECT_NEAR(static_cast<double>(data), 2, 1) << "a third of the bytes";
}

TEST(Backlog, TellsOfCompletenessThoughLiveImagesNeverEnd) {
  RetainedRecords records(kPlenty);
  records.put(Lane::data, 1, record());
  Backlog backlog(records, 0);
  records.put(Lane::live, 0, record());
  EXPECT_THAT(take(backlog), ElementsAre(2, 1, 0));
  records.put(Lane::live, 0, record());
  EXPECT_THAT(take(backlog), ElementsAre(3));
}

TEST(Backlog, TellsWhatCanBeResumedFromAndWhatWasLetGo) {
  RetainedRecords records(2000);
  for (std::uint64_t key = 1; key <= 10; ++key) records.put(Lane::data, key, record(484));
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog, 4), ElementsAre(10, 9, 8, 7));
  const SharedBytes last = backlog.next();
  const auto caught_up = wire::decode_caught_up(*last);
  ASSERT_TRUE(caught_up);
  EXPECT_EQ(caught_up->sequence, 10u);
  EXPECT_EQ(caught_up->evicted, 6u);
}

TEST(RetainedRecords, LetGoOfTheOldestDataBeforeAnyState) {
  RetainedRecords records(1600);
  records.put(Lane::state, 1, record(484));
  for (std::uint64_t key = 1; key <= 5; ++key) records.put(Lane::data, key, record(484));
  EXPECT_EQ(records.bytes(), 1500u);
  EXPECT_EQ(records.evicted(), 3u);
  Backlog backlog(records, 0);
  EXPECT_THAT(take(backlog), ElementsAre(1, 6, 5, 0));
}

TEST(RetainedRecords, HoldNothingLargerThanTheirBudget) {
  RetainedRecords records(1000);
  records.put(Lane::state, 1, record(100));
  records.put(Lane::data, 1, record(5000));
  EXPECT_EQ(records.evicted(), 1u);
  EXPECT_EQ(records.bytes(), 116u);
}

/// Sees what a page sees, and loses its connection now and then.
struct Viewer {
  explicit Viewer(const RetainedRecords& r) : records(r), backlog(r, 0) {}

  void receive(std::size_t at_most) {
    for (std::size_t i = 0; i < at_most; ++i) {
      const SharedBytes bytes = backlog.next();
      if (!bytes) return;
      if (const auto caught_up = wire::decode_caught_up(*bytes)) {
        complete_to = caught_up->sequence;
      } else {
        ++received;
        sequence_of_key[bytes->at(wire::kHeaderSize)] = wire::sequence(*bytes);
      }
    }
  }
  void reconnect() { backlog = Backlog(records, complete_to); }

  const RetainedRecords& records;
  Backlog backlog;
  std::uint64_t complete_to = 0, received = 0;
  std::map<std::uint8_t, std::uint64_t> sequence_of_key;
};

TEST(Backlog, LeavesEveryViewerWithTheNewestOfEachKeyHoweverSlow) {
  std::mt19937 random(1);
  for (const unsigned reconnects : {0u, 20u}) {
    RetainedRecords records(kPlenty);
    Viewer viewer(records);
    std::map<std::uint8_t, std::uint64_t> newest;
    for (std::uint64_t sequence = 1; sequence <= 20'000; ++sequence) {
      const auto key = static_cast<std::uint8_t>(random() % 250);
      wire::Bytes bytes = record(1);
      bytes.back() = key;
      records.put(key < 10 ? Lane::state : Lane::data, key, std::move(bytes));
      newest[key] = sequence;
      if (random() % 8 == 0) viewer.receive(1 + random() % 3);
      if (random() % 1000 == 0) viewer.receive(1000);
      if (random() % 1000 < reconnects) viewer.reconnect();
    }
    viewer.receive(10'000);
    EXPECT_EQ(viewer.sequence_of_key, newest);
    EXPECT_EQ(viewer.complete_to, 20'000u);
    EXPECT_GT(viewer.received, 250u);
  }
}

}  // namespace
}  // namespace nadir::serve
