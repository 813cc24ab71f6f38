// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "dives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>
#include <chrono>
#include <thread>

#include <cstdlib>
#include <fstream>

#include "earlier_dives.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using record::read_text;
using record::ScratchFolder;
using record::write_text;

std::string all_of(const serve::Download& download, std::size_t piece = 1000) {
  std::string text(download.size, '?');
  for (std::size_t at = 0; at < text.size();) {
    const auto size =
        download.read(at, std::span(text).subspan(at, std::min(piece, text.size() - at)));
    if (size <= 0) return "cannot be read at " + std::to_string(at);
    at += static_cast<std::size_t>(size);
  }
  return text;
}

class TheDives : public testing::Test {
 protected:
  TheDives() {
    make("dive-0001-20261128-100000", true);
    make("dive-0002", false);
    make("dive-0010-20261129-190402", true);
    make("holiday", true);
    fs::create_directories(scratch / "dives/photos");
    write_text(scratch / "dives/photos/a.jpg", "x");
    write_text(scratch / "dives/dive-0099", "a file");
    fs::create_directory_symlink(scratch / "dives/holiday", scratch / "dives/dive-0050");
  }
  void make(const std::string& name, bool complete) const {
    const fs::path dive = scratch / "dives" / name;
    for (const char* folder : {"projected", "mosaic2d"}) fs::create_directories(dive / folder);
    write_text(dive / "journal-000.nadir", std::string(700, 'j'));
    write_text(dive / "projected/000001.png", "png");
    write_text(dive / "projected/.spare-1", "spare");
    if (!complete) return;
    write_text(dive / "mosaic2d/mosaic-000.png", "mosaic");
    write_text(dive / "mosaic2d/mosaic-000.pgw", "1");
    write_text(dive / "dive.json", R"({"counts": {"captured": 7}, "area_m2": 2.5})");
  }
  std::string id(const std::string& name) {
    for (const json& dive : dives.list()) {
      if (dive["name"] == name) return dive["id"];
    }
    return "none";
  }
  std::string file_id(const std::string& dive, const std::string& name,
                      const std::string& folder = "") {
    const json told = dives.products(id(dive), folder).value();
    for (const json& product : told["products"]) {
      if (product["name"] == name) return product["id"];
    }
    return "none";
  }

  ScratchFolder scratch;
  LiveDive live;
  record::QuickDisk disk;
  Dives dives{scratch / "dives", live, disk};
};

TEST_F(TheDives, HaveNoTimeThatNoClockShows) {
  make("dive-0012-20269999-100000", false);
  make("dive-0013-20261129-246060", false);
  for (const json& dive : dives.list()) {
    const std::string name = dive["name"];
    EXPECT_TRUE(!name.starts_with("dive-0012") || dive["begun"].is_null());
    EXPECT_TRUE(!name.starts_with("dive-0013") || dive["begun"].is_null());
  }
}

TEST_F(TheDives, AreListedNewestFirst) {
  const json list = dives.list();
  ASSERT_EQ(list.size(), 4u);
  EXPECT_EQ(list[0], json::parse(R"({"id": ")" + list[0]["id"].get<std::string>() + R"(",
    "name": "dive-0010-20261129-190402", "begun": "2026-11-29T19:04:02Z", "images": 7,
    "area_m2": 2.5, "bytes": 753, "complete": true, "recording": false})"));
  EXPECT_EQ(list[1]["name"], "dive-0002");
  EXPECT_EQ(list[1]["complete"], false);
  EXPECT_TRUE(list[1]["begun"].is_null() && list[1]["images"].is_null());
  EXPECT_EQ(list[1]["bytes"], 703);
  EXPECT_EQ(list[2]["name"], "dive-0001-20261128-100000");
  EXPECT_EQ(list[3]["name"], "holiday");
  EXPECT_EQ(dives.list(), list);
}

TEST_F(TheDives, AreKnownByIdsThatLastOverRuns) {
  LiveDive other_live;
  Dives other(scratch / "dives/", other_live, disk);
  EXPECT_EQ(other.list(), dives.list());
  EXPECT_EQ(id("dive-0002").size(), 16u);
}

TEST_F(TheDives, SayWhichIsBeingRecorded) {
  live.begin(scratch / "dives/dive-0002/");
  live.note(3, false, 1);
  EXPECT_EQ(dives.list()[1]["recording"], true);
  EXPECT_EQ(dives.list()[1]["images"], 3);
  EXPECT_EQ(dives.list()[0]["recording"], false);
  live.end();
  EXPECT_EQ(dives.list()[1]["recording"], false);
}

TEST_F(TheDives, ListTheirFilesByKind) {
  const json told = dives.products(id("dive-0010-20261129-190402"), "").value();
  EXPECT_EQ(told["name"], "dive-0010-20261129-190402");
  std::map<std::string, std::string> kinds;
  for (const json& product : told["products"]) kinds[product["name"]] = product["kind"];
  EXPECT_EQ(kinds, (std::map<std::string, std::string>{{"dive.json", "summary"},
                                                       {"journal-000.nadir", "journal"},
                                                       {"mosaic-000.pgw", "place"},
                                                       {"mosaic-000.png", "mosaic"}}));
  EXPECT_EQ(told["folders"], json::parse(R"([{"name": "mosaic2d", "files": 2, "bytes": 7},
                                              {"name": "projected", "files": 1, "bytes": 3}])"));
  const json inner = dives.products(id("dive-0002"), "projected").value();
  ASSERT_EQ(inner["products"].size(), 1u);
  EXPECT_EQ(inner["products"][0]["name"], "000001.png");
  EXPECT_EQ(inner["products"][0]["kind"], "projected");
}

TEST_F(TheDives, HandOutFiles) {
  const std::string dive = "dive-0010-20261129-190402";
  const auto mosaic = dives.file(id(dive), file_id(dive, "mosaic-000.png"));
  ASSERT_TRUE(mosaic);
  EXPECT_EQ(mosaic->name, "mosaic-000.png");
  EXPECT_EQ(all_of(*mosaic), "mosaic");
  const auto projected = dives.file(id(dive), file_id(dive, "000001.png", "projected"));
  ASSERT_TRUE(projected);
  EXPECT_EQ(all_of(*projected), "png");
  const std::string tag = mosaic->tag;
  write_text(scratch / "dives" / dive / "mosaic2d/mosaic-000.png", "another");
  EXPECT_NE(dives.file(id(dive), file_id(dive, "mosaic-000.png"))->tag, tag);
}

TEST_F(TheDives, HandOutImagesByTheirNumber) {
  EXPECT_EQ(all_of(dives.projected(id("dive-0002"), 1).value()), "png");
  EXPECT_EQ(dives.projected(id("dive-0002"), 1)->name, "000001.png");
  EXPECT_FALSE(dives.projected(id("dive-0002"), 2));
  EXPECT_FALSE(dives.projected("none", 1));
}

TEST_F(TheDives, HandOutAFileThatCameSinceTheyWereListed) {
  const std::string dive = "dive-0002";
  file_id(dive, "journal-000.nadir");
  dives.file(id(dive), file_id(dive, "journal-000.nadir"));
  write_text(scratch / "dives/dive-0002/alerts.jsonl", "{}");
  EXPECT_TRUE(dives.file(id(dive), file_id(dive, "alerts.jsonl")));
}

TEST_F(TheDives, KnowNoPaths) {
  const std::string good = id("dive-0010-20261129-190402");
  for (const std::string escape :
       {"", ".", "..", "../dives", "dive-0002", "/etc", "..%2f..", "%2e%2e", "0000000000000000",
        "\xc0\xae\xc0\xae/", "dive.json", "mosaic2d/mosaic-000.png"}) {
    EXPECT_FALSE(dives.products(escape, "")) << escape;
    EXPECT_FALSE(dives.archive(escape)) << escape;
    EXPECT_FALSE(dives.file(good, escape)) << escape;
    EXPECT_EQ(dives.remove(escape), Dives::Removal::unknown) << escape;
    EXPECT_TRUE(escape.empty() || !dives.products(good, escape)) << escape;
  }
}

TEST_F(TheDives, LeadNowhereElse) {
  write_text(scratch / "secret", "secret");
  const fs::path dive = scratch / "dives/dive-0002";
  fs::create_symlink(scratch / "secret", dive / "link.csv");
  fs::create_directory_symlink(scratch / "dives/holiday", dive / "survey");
  ASSERT_EQ(::mkfifo((dive / "fifo").c_str(), 0600), 0);
  const json told = dives.products(id("dive-0002"), "").value();
  for (const json& product : told["products"]) {
    EXPECT_EQ(product["name"], "journal-000.nadir");
  }
  EXPECT_EQ(told["folders"].size(), 2u);
  EXPECT_FALSE(dives.products(id("dive-0002"), "survey"));
  // What is exchanged for a link after it was listed is not followed either.
  const std::string file = file_id("dive-0002", "journal-000.nadir");
  ASSERT_TRUE(dives.file(id("dive-0002"), file));
  fs::create_directories(dive / "mosaic2d");
  fs::remove(dive / "journal-000.nadir");
  write_text(dive / "dive.json", "{}");
  fs::create_symlink(scratch / "secret", dive / "journal-000.nadir");
  EXPECT_FALSE(dives.file(id("dive-0002"), file));
}

TEST_F(TheDives, ComeWholeAsATar) {
  const std::string name = "dive-0010-20261129-190402";
  const auto archive = dives.archive(id(name));
  ASSERT_TRUE(archive);
  EXPECT_EQ(archive->name, name + ".tar");
  const std::string bytes = all_of(*archive);
  for (const std::size_t piece : {1, 7, 511, 512, 513, 100000}) {
    EXPECT_TRUE(all_of(*archive, piece) == bytes) << piece;
  }
  write_text(scratch / "all.tar", bytes);
  fs::create_directories(scratch / "out");
  const std::string command =
      "tar -C '" + (scratch / "out").string() + "' -xf '" + (scratch / "all.tar").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  auto files = record::read_all(scratch / "dives" / name);
  files.erase("projected/.spare-1");
  EXPECT_EQ(record::read_all(scratch / "out" / name), files);
}

TEST_F(TheDives, BreakATarOffWhoseFilesGo) {
  const auto archive = dives.archive(id("dive-0002"));
  fs::resize_file(scratch / "dives/dive-0002/journal-000.nadir", 100);
  EXPECT_THAT(all_of(*archive), testing::StartsWith("cannot be read at"));
}

TEST_F(TheDives, AreRemovedWhole) {
  EXPECT_EQ(dives.remove(id("holiday")), Dives::Removal::done);
  EXPECT_FALSE(fs::exists(scratch / "dives/holiday"));
  EXPECT_EQ(dives.list().size(), 3u);
  EXPECT_TRUE(fs::exists(scratch / "dives/photos/a.jpg"));
}

TEST_F(TheDives, AreNotRemovedWhileTheyAreWritten) {
  live.begin(scratch / "dives/dive-0002");
  EXPECT_EQ(dives.remove(id("dive-0002")), Dives::Removal::in_use);
  live.end();
  {
    const record::FolderLock recovery(scratch / "dives/dive-0002");
    ASSERT_TRUE(recovery.held());
    EXPECT_EQ(dives.remove(id("dive-0002")), Dives::Removal::in_use);
  }
  EXPECT_EQ(dives.remove(id("dive-0002")), Dives::Removal::done);
}

TEST_F(TheDives, WhoseRemovalWasCutOffAreNoDives) {
  fs::rename(scratch / "dives/dive-0002", scratch / "dives/.removed-dive-0002");
  EXPECT_TRUE(unfinished_dives(scratch / "dives").empty());
  EXPECT_EQ(dives.list().size(), 3u);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (fs::exists(scratch / "dives/.removed-dive-0002") && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(fs::exists(scratch / "dives/.removed-dive-0002"));
}

TEST_F(TheDives, WhoseRemovalIsNotAllowedStayInPart) {
  const fs::path first = scratch / "dives/.removed-first",
                 second = scratch / "dives/.removed-second";
  for (const fs::path& removed : {first, second}) {
    fs::create_directories(removed / "locked");
    write_text(removed / "file", "x");
    write_text(removed / "locked/file", "x");
    fs::permissions(removed, fs::perms::all);
    fs::permissions(removed / "locked", fs::perms::none);
  }
  for (const fs::path& above : {fs::path(scratch / "."), scratch / "dives"}) {
    fs::permissions(above, fs::perms::all);
  }
  constexpr uid_t kNobody = 65534;
  const uid_t before = ::geteuid();  // no permission holds root back
  if (before == 0) {
    ASSERT_EQ(::seteuid(kNobody), 0);
  }
  dives.list();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while ((fs::exists(first / "file") || fs::exists(second / "file")) &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(::seteuid(before), 0);
  for (const fs::path& removed : {first, second}) {
    EXPECT_FALSE(fs::exists(removed / "file"));
    EXPECT_TRUE(fs::exists(removed / "locked"));
    fs::permissions(removed / "locked", fs::perms::all);
  }
}

TEST_F(TheDives, StayWholeOnADiskThatDoesNotLetThemGo) {
  record::FailingDisk broken;
  broken.verdict = [](record::FailingDisk::Call call) {
    return call == record::FailingDisk::Call::rename ? -EROFS : 0;
  };
  Dives on_broken(scratch / "dives", live, broken);
  const auto before = record::read_all(scratch / "dives");
  EXPECT_EQ(on_broken.remove(id("holiday")), Dives::Removal::failed);
  EXPECT_EQ(record::read_all(scratch / "dives"), before);
}

TEST_F(TheDives, AreNoneWhereThereIsNoFolder) {
  Dives none(scratch / "nowhere", live, disk);
  EXPECT_EQ(none.list(), json::array());
}

TEST_F(TheDives, SurviveADamagedSummary) {
  write_text(scratch / "dives/holiday/dive.json", "{\"counts\": [");
  write_text(scratch / "dives/dive-0010-20261129-190402/dive.json", "[1]");
  const json list = dives.list();
  EXPECT_TRUE(list[0]["images"].is_null());
  EXPECT_TRUE(list[3]["images"].is_null());
}

TEST_F(TheDives, TakeNothingButAmountsFromASummary) {
  const std::string deep(300'000, '[');
  const auto images_of = [&](const std::string& captured) {
    write_text(scratch / "dives/holiday/dive.json",
               R"({"counts": {"captured": )" + captured + "}}");
    Dives anew(scratch / "dives", live, disk);
    return anew.list().back()["images"];
  };
  EXPECT_EQ(images_of("12"), 12);
  for (const std::string& nonsense :
       {deep + std::string(deep.size(), ']'), std::string("\"12\""), std::string("-1"),
        std::string("1e300"), std::string("{}"), std::string("null")}) {
    EXPECT_TRUE(images_of(nonsense).is_null()) << nonsense.substr(0, 20);
  }
}

}  // namespace
}  // namespace nadir::app
