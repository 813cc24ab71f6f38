// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Marks in the dive: durable when told so, moved with the ground, made again by a recovery.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "nadir/record/recover.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

class Marks : public testing::Test {
 protected:
  static Mark mark(std::uint64_t id, std::optional<std::uint64_t> image = {}) {
    return {.id = id,
            .time = 1'500'000'000,
            .image = image,
            .position = {1, 2, -3},
            .note = "an \"anchor\""};
  }
  std::vector<json> lines(const std::string& name) const {
    std::vector<json> all;
    std::istringstream text(read_text(folder / name));
    for (std::string line; std::getline(text, line);) all.push_back(json::parse(line));
    return all;
  }

  SmallDive small;
  ScratchFolder scratch;
  path folder = scratch / "dive";
};

TEST_F(Marks, AreInAFileOfTheirOwnWhenThereAreAny) {
  {
    Dive dive(folder, small.info(), {});
    ASSERT_TRUE(dive.add(small.entry(0)).empty());
    EXPECT_TRUE(dive.add(mark(0, 0)));
    EXPECT_TRUE(dive.add(mark(1)));
    EXPECT_TRUE(dive.add(mark(2)));
    Mark removed = mark(1);
    removed.removed = true;
    EXPECT_TRUE(dive.add(removed));
    ASSERT_TRUE(dive.finish({}).empty());
  }
  const auto told = lines("marks.jsonl");
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0], json::parse(R"({"id": 0, "time_s": 1.5, "image": 0,
    "note": "an \"anchor\"", "position_survey_units": [1, 2, -3]})"));
  EXPECT_EQ(told[1]["id"], 2);
  EXPECT_TRUE(told[1]["image"].is_null());
  EXPECT_TRUE(json::parse(read_text(folder / "dive.json"))["files"].contains("marks.jsonl"));
  EXPECT_FALSE(std::filesystem::exists(folder / "marks.geojson"));

  Dive without(scratch / "without", small.info(), {});
  ASSERT_TRUE(without.add(small.entry(0)).empty());
  ASSERT_TRUE(without.finish({}).empty());
  EXPECT_FALSE(std::filesystem::exists(scratch / "without/marks.jsonl"));
}

TEST_F(Marks, AreMadeAgainByARecovery) {
  {
    Dive dive(folder, small.info(), {});
    ASSERT_TRUE(dive.add(small.entry(0)).empty());
    EXPECT_TRUE(dive.add(mark(0)));
  }
  EXPECT_TRUE(recover(folder).whole());
  EXPECT_EQ(lines("marks.jsonl").size(), 1u);
}

TEST_F(Marks, MoveAsTheirImageDoesFromWhereTheyWerePut) {
  const auto moved_by = [](double metres) {
    auto revision = std::make_shared<Revision>();
    Similarity3 correction;
    correction.rigid.translation.x() = metres;
    revision->corrections.push_back({0, 0, correction});
    return revision;
  };
  {
    Dive dive(folder, small.info(), {});
    ASSERT_TRUE(dive.add(small.entry(0)).empty());
    EXPECT_TRUE(dive.add(mark(0, 0)));
    EXPECT_TRUE(dive.add(mark(1)));  // of no image: stays
    Entry entry = small.entry(1);
    entry.revisions = {moved_by(10)};
    ASSERT_TRUE(dive.add(entry).empty());
    EXPECT_TRUE(dive.add(mark(2, 0)));  // on ground that is moved already
    entry = small.entry(2);
    entry.revisions = {moved_by(15)};
    ASSERT_TRUE(dive.add(entry).empty());
    ASSERT_TRUE(dive.finish({}).empty());
  }
  const auto told = lines("marks.jsonl");
  ASSERT_EQ(told.size(), 3u);
  EXPECT_NEAR(told[0]["position_survey_units"][0], 16, 1e-9);
  EXPECT_NEAR(told[1]["position_survey_units"][0], 1, 1e-9);
  EXPECT_NEAR(told[2]["position_survey_units"][0], 6, 1e-9);
}

TEST_F(Marks, LieOnTheEarthWhereTheSurveyDoes) {
  DiveInfo info = small.info();
  info.origin = {46.05, 14.5, 300};
  {
    Dive dive(folder, info, {});
    ASSERT_TRUE(dive.add(small.entry(0)).empty());
    EXPECT_TRUE(dive.add(mark(0)));
    ASSERT_TRUE(dive.finish({}).empty());
  }
  const json told = json::parse(read_text(folder / "marks.geojson"));
  EXPECT_EQ(told["type"], "FeatureCollection");
  const json& feature = told["features"][0];
  EXPECT_EQ(feature["properties"]["note"], "an \"anchor\"");
  const json& place = feature["geometry"]["coordinates"];
  EXPECT_NEAR(place[0], 14.5, 1e-4);
  EXPECT_NEAR(place[1], 46.05, 1e-4);
  EXPECT_NEAR(place[2], 297, 1e-3);
  EXPECT_GT(lines("marks.jsonl")[0]["northing_m"].get<double>(), 5e6);
}

TEST_F(Marks, ThatAreNotDurableAreNotClaimed) {
  FailingDisk disk;
  Dive dive(folder, small.info(), {}, disk);
  disk.verdict = [](FailingDisk::Call call) { return call == FailingDisk::Call::sync ? -EIO : 0; };
  EXPECT_FALSE(dive.add(mark(0)));
  disk.verdict = [](FailingDisk::Call) { return 0; };
  EXPECT_TRUE(dive.add(mark(1)));
  Mark infinite = mark(2);
  infinite.position.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(dive.add(infinite));
  ASSERT_TRUE(dive.add(small.entry(0)).empty());
  ASSERT_TRUE(dive.finish({}).empty());
  EXPECT_EQ(lines("marks.jsonl").size(), 1u);
}

}  // namespace
}  // namespace nadir::record
