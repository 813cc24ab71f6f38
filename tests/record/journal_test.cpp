// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "journal.hpp"

#include <gtest/gtest.h>
#include <libdeflate.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "facts.hpp"
#include "nadir/core/check.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

struct Read {
  std::vector<std::uint64_t> sequences;
  std::vector<std::string> texts;
  std::uint64_t missing = 0;
};

Read read_journal(const path& folder) {
  JournalReader reader(folder);
  Read read;
  while (const auto record = reader.next()) {
    read.sequences.push_back(record->sequence);
    read.texts.emplace_back(record->payload.begin(), record->payload.end());
  }
  read.missing = reader.missing();
  return read;
}

void write_journal(Disk& disk, const path& folder, int records) {
  JournalWriter writer(disk, folder);
  for (int i = 0; i < records; ++i) {
    const std::string text(static_cast<std::size_t>(3 * i), static_cast<char>('a' + i));
    ASSERT_EQ(writer.append(RecordType::shot, as_bytes(text)), 0);
  }
}

constexpr const char* kFirst = "journal-000.nadir";
constexpr std::size_t kHeader = 28, kRecordHeader = 24;

TEST(Journal, GivesBackWhatWasAppended) {
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 4);
  const Read read = read_journal(folder / "");
  EXPECT_EQ(read.texts, (std::vector<std::string>{"", "bbb", "cccccc", "ddddddddd"}));
  EXPECT_EQ(read.missing, 0u);
}

TEST(Journal, TakesSeveralRecordsWithOneSync) {
  const ScratchFolder folder;
  struct CountingDisk : QuickDisk {
    int syncs = 0, failures = 0;
    int sync(int) override { return ++syncs, failures-- > 0 ? -EIO : 0; }
  } disk;
  JournalWriter writer(disk, folder / "");
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("one")), 0);
  disk.syncs = 0;
  const std::vector<ByteView> two{as_bytes("two"), as_bytes("three")};
  EXPECT_EQ(writer.append(RecordType::alert, two), 0);
  EXPECT_EQ(disk.syncs, 1);
  disk.failures = 1;  // what the failed sync left is not told twice
  EXPECT_EQ(writer.append(RecordType::alert, two), 0);
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("four")), 0);
  writer.close();
  const Read read = read_journal(folder / "");
  EXPECT_EQ(read.texts, (std::vector<std::string>{"one", "two", "three", "two", "three", "four"}));
  EXPECT_EQ(read.sequences, (std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(read.missing, 0u);
}

TEST(Journal, CutAnywhereHoldsTheRecordsBeforeTheCut) {
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 4);
  const std::string whole = read_text(folder / kFirst);
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    write_text(folder / kFirst, whole.substr(0, size));
    std::size_t expected = 0;
    for (std::size_t end = kHeader; expected < 4; ++expected) {
      end += kRecordHeader + 3 * expected;
      if (end > size) break;
    }
    const Read read = read_journal(folder / "");
    EXPECT_EQ(read.texts.size(), expected) << size;
    EXPECT_EQ(read.missing, 0u) << size;
  }
}

TEST(Journal, LosesNothingToAFlippedBitOfItsHeader) {
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 4);
  const std::string whole = read_text(folder / kFirst);
  for (std::size_t at = 0; at < kHeader; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ 1 << bit);
      write_text(folder / kFirst, flipped);
      EXPECT_EQ(read_journal(folder / "").texts.size(), 4u) << at << ' ' << bit;
    }
  }
}

std::string refusal(const path& folder) {
  try {
    (void)read_journal(folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

// Up to version 4 the header had no checksum.
TEST(Journal, OfAnotherVersionIsRefusedAndLeftAsItIs) {
  constexpr std::size_t kVersion = 8, kChecksum = 24;
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 4);
  const std::string whole = read_text(folder / kFirst);
  std::string earlier = whole;
  earlier[kVersion] = 4;
  earlier.erase(kChecksum, 4);
  write_text(folder / kFirst, earlier);
  EXPECT_NE(refusal(folder / "").find("by an earlier version"), std::string::npos);
  EXPECT_EQ(read_text(folder / kFirst), earlier);
  std::string later = whole;
  later[kVersion] = 99;
  const std::uint32_t sum = libdeflate_crc32(0, later.data(), kChecksum);
  for (std::size_t i = 0; i < 4; ++i) later[kChecksum + i] = static_cast<char>(sum >> 8 * i & 0xFF);
  write_text(folder / kFirst, later);
  EXPECT_NE(refusal(folder / "").find("by a later version"), std::string::npos);
  EXPECT_THROW(JournalReader(folder / "nowhere"), InputError);
}

TEST(Journal, LosesOneRecordToAFlippedBitAndSaysSo) {
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 4);
  const std::string whole = read_text(folder / kFirst);
  constexpr std::size_t kLast = kHeader + 3 * kRecordHeader + 9;
  for (std::size_t at = kHeader; at < whole.size(); ++at) {
    for (const int bit : {0, 3, 7}) {
      std::string rotten = whole;
      rotten[at] = static_cast<char>(rotten[at] ^ (1 << bit));
      write_text(folder / kFirst, rotten);
      const Read read = read_journal(folder / "");
      EXPECT_EQ(read.texts.size(), 3u) << at;
      EXPECT_EQ(read.missing, at < kLast ? 1u : 0u) << at;  // the last may as well be torn
    }
  }
}

TEST(Journal, FindsARecordBehindGarbage) {
  const ScratchFolder folder;
  QuickDisk disk;
  write_journal(disk, folder / "", 3);
  std::string text = read_text(folder / kFirst);
  text.insert(24, std::string(70000, 'N') + "NDR" + std::string(65530, '\0'));
  write_text(folder / kFirst, text);
  EXPECT_EQ(read_journal(folder / "").texts.size(), 3u);
}

TEST(Journal, GoesOnInANewSegmentAfterAFailedSync) {
  const ScratchFolder folder;
  FailingDisk disk;
  JournalWriter writer(disk, folder / "");
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("one")), 0);
  int failures = 1;
  disk.verdict = [&](FailingDisk::Call call) {
    return call == FailingDisk::Call::sync && failures-- > 0 ? -EIO : 0;
  };
  EXPECT_EQ(writer.append(RecordType::shot, as_bytes("two")), 0);
  EXPECT_EQ(writer.append(RecordType::shot, as_bytes("three")), 0);
  writer.close();
  EXPECT_TRUE(std::filesystem::exists(folder / "journal-001.nadir"));
  const Read read = read_journal(folder / "");
  EXPECT_EQ(read.texts, (std::vector<std::string>{"one", "two", "three"}));
  EXPECT_EQ(read.missing, 0u);
}

TEST(Journal, GivesARecordOnceThatReachedTheDiskTwice) {
  const ScratchFolder folder;
  // The sync fails but the data are there all the same.
  struct LyingDisk : QuickDisk {
    int failures = 0;
    int sync(int) override { return failures-- > 0 ? -EIO : 0; }
  } disk;
  JournalWriter writer(disk, folder / "");
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("one")), 0);
  disk.failures = 1;
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("two")), 0);
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("three")), 0);
  writer.close();
  EXPECT_EQ(read_journal(folder / "").texts, (std::vector<std::string>{"one", "two", "three"}));
}

TEST(Journal, LeavesNoHeapOfSegmentsWhenTheDiskIsFull) {
  const ScratchFolder folder;
  FailingDisk disk;
  JournalWriter writer(disk, folder / "");
  ASSERT_EQ(writer.append(RecordType::shot, as_bytes("one")), 0);
  disk.verdict = [](FailingDisk::Call call) {
    return call == FailingDisk::Call::write ? -ENOSPC : 0;
  };
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(writer.append(RecordType::shot, as_bytes("lost")), -ENOSPC);
  }
  disk.verdict = [](FailingDisk::Call) { return 0; };
  EXPECT_EQ(writer.append(RecordType::shot, as_bytes("two")), 0);
  writer.close();
  EXPECT_EQ(read_all(folder / "").size(), 2u);
  const Read read = read_journal(folder / "");
  EXPECT_EQ(read.texts, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(read.missing, 0u);
}

TEST(Facts, AreTheSameAfterTheJournal) {
  SmallDive small;
  const Facts facts = facts_of(small.entry(2));
  const Bytes bytes = encode(facts);
  const auto back = decode_facts(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode(*back), bytes);
  EXPECT_EQ(back->name, "dsc,2");
  EXPECT_EQ(back->window->tie_points.at(1).x_in_survey, facts.window->tie_points[1].x_in_survey);
  EXPECT_EQ(back->plane->centroid, facts.plane->centroid);
  EXPECT_EQ(cv::norm(back->grid->bgr, facts.grid->bgr, cv::NORM_INF), 0);
  EXPECT_EQ(back->tiles, facts.tiles);
}

TEST(Facts, AreReadWithoutPixelsEvenIfTheseAreDamaged) {
  const Facts facts = facts_of(SmallDive{}.entry(2));
  Bytes bytes = encode(facts);
  const std::string_view signature = "PNG";
  const auto png = std::search(bytes.begin(), bytes.end(), signature.begin(), signature.end());
  ASSERT_NE(png, bytes.end());
  *png = 'p';
  EXPECT_FALSE(decode_facts(bytes));
  const auto back = decode_facts(bytes, false);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->grid->bgr.size(), facts.grid->bgr.size());
  EXPECT_EQ(cv::countNonZero(back->grid->bgr.reshape(1)), 0);
  EXPECT_EQ(back->grid->survey_from_grid, facts.grid->survey_from_grid);
  EXPECT_EQ(back->alerts.size(), facts.alerts.size());
}

TEST(Facts, LeaveOutWhatNoMapCanHold) {
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), -1e300}) {
    Facts facts = facts_of(SmallDive{}.entry(2));
    facts.poses.push_back(facts.poses[0]);
    facts.poses[0].survey_from_camera.translation.y() = wrong;
    facts.dead_reckoned = DeadReckoned{2, 0, {}, wrong};
    facts.window->tie_points[1].x_in_survey.x() = wrong;
    facts.window->scale.sigma = wrong;
    facts.grid->survey_from_grid(3, 2) = wrong;
    facts.mosaic->world.c = wrong;
    facts.corrections = {{1, 0, {wrong, {}}}, {2, 0, {2, {}}}};
    const auto back = decode_facts(encode(facts));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->name, "dsc,2");
    EXPECT_EQ(back->poses.size(), 1u);
    EXPECT_FALSE(back->dead_reckoned);
    EXPECT_EQ(back->window->tie_points.size(), SmallDive::kPointsEach - 1);
    EXPECT_EQ(back->window->scale.source, ScaleSource::none);
    EXPECT_TRUE(back->plane);
    EXPECT_FALSE(back->grid);
    EXPECT_FALSE(back->mosaic);
    EXPECT_TRUE(back->tiles.empty());
    ASSERT_EQ(back->corrections.size(), 1u);
    EXPECT_EQ(back->corrections[0].image, 2u);
  }
}

TEST(Facts, CutShortAreNone) {
  const Bytes bytes = encode(facts_of(SmallDive{}.entry(1)));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decode_facts(ByteView(bytes).first(size))) << size;
  }
}

TEST(Facts, OfHostileLengthsTakeNoMemory) {
  const Bytes hostile(200, 0xff);
  EXPECT_FALSE(decode_facts(hostile));
  EXPECT_FALSE(decode_alert(hostile));
}

}  // namespace
}  // namespace nadir::record
