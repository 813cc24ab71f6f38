// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A disk that fails at any call, in any way: the dive goes on and never claims what it has not got.
#include <gtest/gtest.h>
#include <unistd.h>

#include "nadir/core/check.hpp"
#include "nadir/record/recover.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

struct Outcome {
  bool began = true;
  std::vector<bool> saved;  ///< by image
  std::vector<Alert> alerts;
  bool finished = false;
};

Outcome record_dive(const SmallDive& small, const path& folder, Disk& disk) {
  Outcome outcome;
  try {
    Dive dive(folder, small.info(), {}, disk);
    for (int i = 0; i < small.images; ++i) {
      const std::uint64_t before = dive.saved();
      const auto alerts = dive.add(small.entry(static_cast<std::uint64_t>(i)));
      outcome.saved.push_back(dive.saved() > before);
      outcome.alerts.insert(outcome.alerts.end(), alerts.begin(), alerts.end());
    }
    outcome.finished = dive.finish({}).empty();
  } catch (const InputError&) {
    outcome.began = false;
  }
  return outcome;
}

// With a sound disk again, all that was acknowledged is there and the counts add up.
void expect_honest(const path& folder, const Outcome& outcome, std::uint64_t captured_at_most) {
  QuickDisk sound;
  const Recovery recovery = recover(folder, sound);
  const auto saved = static_cast<std::uint64_t>(std::ranges::count(outcome.saved, true));
  EXPECT_GE(recovery.oriented, saved);
  EXPECT_LE(recovery.captured, captured_at_most);
  EXPECT_EQ(recovery.captured, recovery.oriented + recovery.lost + recovery.dropped);
  EXPECT_EQ(recovery.missing_records, 0u);
  const std::string health = read_text(folder / "health.csv");
  for (std::size_t i = 0; i < outcome.saved.size(); ++i) {
    const std::string name = "\"dsc," + std::to_string(i) + "\"";
    EXPECT_TRUE(!outcome.saved[i] || health.find(name) != std::string::npos) << i;
  }
  for (const auto& [name, text] : read_all(folder)) {
    EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
  }
  EXPECT_TRUE(recover(folder, sound).made.empty()) << "nothing was left to do";
}

int calls_of_a_good_dive(const SmallDive& small) {
  const ScratchFolder scratch;
  FailingDisk disk;
  int calls = 0;
  disk.verdict = [&](FailingDisk::Call) { return ++calls, 0; };
  EXPECT_TRUE(record_dive(small, scratch / "dive", disk).finished);
  return calls;
}

class Fault : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Fault,
                         testing::Values(-ENOSPC, -EIO, -EROFS, -EINTR, FailingDisk::kShort));

TEST_P(Fault, AtAnySingleCallIsSurvivedWithoutALie) {
  SmallDive small;
  small.images = 3;
  small.with_tiles = false;
  const int calls = calls_of_a_good_dive(small);
  for (int n = 1; n <= calls; ++n) {
    SCOPED_TRACE(n);
    const ScratchFolder scratch;
    FailingDisk disk;
    int call = 0;
    disk.verdict = [&](FailingDisk::Call) { return ++call == n ? GetParam() : 0; };
    const Outcome outcome = record_dive(small, scratch / "dive", disk);
    EXPECT_EQ(std::filesystem::exists(scratch / "dive"), outcome.began);
    if (!outcome.began) continue;
    const bool harmless = GetParam() == -EINTR || GetParam() == FailingDisk::kShort;
    EXPECT_TRUE(!harmless || (outcome.finished && outcome.alerts.empty()));
    expect_honest(scratch / "dive", outcome, 3);
  }
}

TEST_P(Fault, FromAnyCallOnForGoodIsSurvivedWithoutALie) {
  if (GetParam() == -EINTR) return;  // for ever interrupted: no disk does that
  SmallDive small;
  small.images = 3;
  small.with_tiles = false;
  const int calls = calls_of_a_good_dive(small);
  for (int n = 1; n <= calls; n += 2) {
    SCOPED_TRACE(n);
    const ScratchFolder scratch;
    FailingDisk disk;
    int call = 0;
    disk.verdict = [&](FailingDisk::Call) { return ++call >= n ? GetParam() : 0; };
    const Outcome outcome = record_dive(small, scratch / "dive", disk);
    if (!outcome.began) continue;
    // Temporaries may stay where nothing can be removed; recovery removes them.
    expect_honest(scratch / "dive", outcome, 3);
  }
}

TEST(FullDisk, PausesRecordingAndResumesWhenSpaceReturns) {
  SmallDive small;
  const ScratchFolder scratch;
  FailingDisk disk;
  Dive dive(scratch / "dive", small.info(), {}, disk);
  ASSERT_TRUE(dive.add(small.entry(0)).empty());
  const auto full = [](FailingDisk::Call call) {
    return call == FailingDisk::Call::write || call == FailingDisk::Call::open ? -ENOSPC : 0;
  };
  disk.verdict = full;
  const auto paused = dive.add(small.entry(1));
  ASSERT_EQ(paused.size(), 1u);
  EXPECT_EQ(paused[0].kind, AlertKind::storage);
  EXPECT_EQ(paused[0].image, 1u);
  EXPECT_NE(paused[0].message.find("No space left"), std::string::npos) << paused[0].message;
  EXPECT_FALSE(paused[0].remedy.empty());
  EXPECT_TRUE(dive.add(small.entry(2)).empty()) << "told once";
  disk.verdict = [](FailingDisk::Call) { return 0; };
  const auto resumed = dive.add(small.entry(3));
  ASSERT_EQ(resumed.size(), 1u);
  EXPECT_EQ(resumed[0].kind, AlertKind::storage_back);
  EXPECT_NE(resumed[0].message.find("not recorded: 2"), std::string::npos) << resumed[0].message;
  EXPECT_EQ(dive.seen(), 4u);
  EXPECT_EQ(dive.saved(), 2u);
  ASSERT_TRUE(dive.finish({}).empty());
  const json counts = json::parse(read_text(scratch / "dive/dive.json"))["counts"];
  EXPECT_EQ(counts["captured"], 4);
  EXPECT_EQ(counts["oriented"], 2);
  EXPECT_EQ(counts["dropped"]["storage"], 2);
  const std::string alerts = read_text(scratch / "dive/alerts.jsonl");
  EXPECT_EQ(std::ranges::count(alerts, '\n'), 2);
}

TEST(FullDisk, ForImagesOnlyStillRecordsTheRest) {
  SmallDive small;
  const ScratchFolder scratch;
  FailingDisk disk;
  Dive dive(scratch / "dive", small.info(), {}, disk);
  int writes = 0;
  // The image's write comes before the journal's.
  disk.verdict = [&](FailingDisk::Call call) {
    return call == FailingDisk::Call::write && writes++ == 0 ? -EIO : 0;
  };
  const auto alerts = dive.add(small.entry(0));
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_NE(alerts[0].message.find("projected images are not saved"), std::string::npos);
  EXPECT_EQ(dive.saved(), 1u);
  EXPECT_EQ(dive.add(small.entry(1)).size(), 1u);
  ASSERT_TRUE(dive.finish({}).empty());
  EXPECT_FALSE(std::filesystem::exists(scratch / "dive/projected/000000.png"));
  EXPECT_TRUE(std::filesystem::exists(scratch / "dive/projected/000001.png"));
}

int syncs_of_alerts(std::size_t count) {
  struct CountingDisk : QuickDisk {
    int syncs = 0;
    int sync(int) override { return ++syncs, 0; }
  } disk;
  const SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {}, disk);
  const std::vector<Alert> alerts(
      count, {0, std::nullopt, AlertKind::camera_lost, "gives no images", "none needed"});
  const int before = disk.syncs;
  dive.add(alerts);
  const int syncs = disk.syncs - before;
  EXPECT_TRUE(dive.finish({}).empty());
  const std::string recorded = read_text(scratch / "dive/alerts.jsonl");
  EXPECT_EQ(std::ranges::count(recorded, '\n'), static_cast<std::ptrdiff_t>(count));
  return syncs;
}

TEST(SlowDisk, RecordsManyAlertsAtOnce) {
  EXPECT_EQ(syncs_of_alerts(0), 0);
  EXPECT_EQ(syncs_of_alerts(1), 1);
  EXPECT_EQ(syncs_of_alerts(100), 1);
}

TEST(LostDisk, IsToldAtTheEnd) {
  SmallDive small;
  const ScratchFolder scratch;
  Dive dive(scratch / "dive", small.info(), {});
  ASSERT_TRUE(dive.add(small.entry(0)).empty());
  std::filesystem::remove_all(scratch / "dive");
  const auto alerts = dive.finish({});
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::storage);
}

}  // namespace
}  // namespace nadir::record
