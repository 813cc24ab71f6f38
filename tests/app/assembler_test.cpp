// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace nadir::app {
namespace {

struct Parts {
  std::shared_ptr<const Orientation> orientation;
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const Cloud> cloud;
  std::shared_ptr<const MosaicUpdate> mosaic;
  std::shared_ptr<const Revision> revision;
};

// Parts of image i; the last, without a shot, is what odometry says at the end of the input.
Parts parts_of(std::optional<std::uint64_t> image) {
  Orientation orientation;
  if (image) {
    Shot shot;
    shot.image = *image;
    orientation.shot = std::make_shared<const Shot>(shot);
  }
  Parts parts;
  parts.orientation = std::make_shared<const Orientation>(orientation);
  parts.surface = std::make_shared<const Surface>(Surface{parts.orientation, {}, {}, {}});
  parts.cloud = std::make_shared<const Cloud>(Cloud{parts.surface, {}, {}});
  parts.mosaic = std::make_shared<const MosaicUpdate>(MosaicUpdate{parts.surface, {}, {}, {}, {}});
  Revision revision{image, {}, {{1, 0, 2, 3}}, {}, {}};
  parts.revision = std::make_shared<const Revision>(revision);
  return parts;
}

TEST(Assembler, EntriesAreTheSameInAnyInterleavingOfTheStreams) {
  constexpr int kShots = 20;
  std::vector<Parts> all;
  for (std::uint64_t i = 0; i < kShots; ++i) all.push_back(parts_of(3 * i));
  all.push_back(parts_of(std::nullopt));
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<record::Entry> entries;
    Assembler assembler(Assembler::Revisions::in_step,
                        [&](const record::Entry& entry) { entries.push_back(entry); });
    std::vector<int> order;  // stream numbers, shuffled: each stream stays in its own order
    for (int stream = 0; stream < 5; ++stream) order.insert(order.end(), all.size(), stream);
    std::shuffle(order.begin(), order.end(), random);
    std::array<std::size_t, 5> next{};
    for (const int stream : order) {
      const Parts& parts = all[next[static_cast<std::size_t>(stream)]++];
      if (stream == 0) assembler.add(parts.orientation);
      if (stream == 1) assembler.add(parts.surface);
      if (stream == 2) assembler.add(parts.cloud);
      if (stream == 3) assembler.add(parts.mosaic);
      if (stream == 4) assembler.add(parts.revision);
    }
    assembler.finish();
    ASSERT_EQ(entries.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(entries[i].orientation, all[i].orientation);
      EXPECT_EQ(entries[i].surface, all[i].surface);
      EXPECT_EQ(entries[i].cloud, all[i].cloud);
      EXPECT_EQ(entries[i].mosaic, all[i].mosaic);
      EXPECT_EQ(entries[i].revisions, std::vector{all[i].revision});
    }
  }
}

TEST(Assembler, PartsDroppedOnALiveEdgeAreLeftOut) {
  std::vector<record::Entry> entries;
  Assembler assembler(Assembler::Revisions::as_come,
                      [&](const record::Entry& entry) { entries.push_back(entry); });
  const Parts first = parts_of(0), second = parts_of(1);
  assembler.add(first.orientation);
  assembler.add(first.surface);
  assembler.add(first.cloud);
  EXPECT_TRUE(entries.empty());  // the mosaic may still come
  assembler.add(second.orientation);
  assembler.add(second.mosaic);  // it was dropped
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].cloud, first.cloud);
  EXPECT_EQ(entries[0].mosaic, nullptr);
  assembler.finish();
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[1].mosaic, second.mosaic);
  EXPECT_EQ(entries[1].surface, nullptr);
}

TEST(Assembler, LiveEntriesDoNotWaitForRevisionsButTheLastTakesAll) {
  std::vector<record::Entry> entries;
  Assembler assembler(Assembler::Revisions::as_come,
                      [&](const record::Entry& entry) { entries.push_back(entry); });
  const auto add = [&](const Parts& parts) {
    assembler.add(parts.orientation);
    assembler.add(parts.surface);
    assembler.add(parts.cloud);
    assembler.add(parts.mosaic);
  };
  const Parts first = parts_of(0), second = parts_of(1), end = parts_of(std::nullopt);
  add(first);
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_TRUE(entries[0].revisions.empty());
  assembler.add(first.revision);
  add(second);
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[1].revisions, std::vector{first.revision});
  add(end);
  assembler.add(second.revision);
  EXPECT_EQ(entries.size(), 2u);
  assembler.add(end.revision);
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_EQ(entries[2].revisions, (std::vector{second.revision, end.revision}));
}

}  // namespace
}  // namespace nadir::app
