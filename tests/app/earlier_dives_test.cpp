// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "earlier_dives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/failing_folder.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using testing::StartsWith;

class EarlierDives : public testing::Test {
 protected:
  EarlierDives() {
    std::string name = testing::TempDir() + "nadir-dives-XXXXXX";
    dives = mkdtemp(name.data());
  }
  ~EarlierDives() override { fs::remove_all(dives); }

  void make(const std::string& dive, const std::vector<std::string>& files) const {
    fs::create_directory(dives / dive);
    for (const std::string& file : files) std::ofstream(dives / dive / file) << "x";
  }

  fs::path dives;
};

TEST_F(EarlierDives, ANewOneHasANumberNoOtherHas) {
  EXPECT_THAT(new_dive(dives).filename().string(), StartsWith("dive-0001"));
  EXPECT_EQ(new_dive(dives).parent_path(), dives);
  make("dive-0001", {});
  make("dive-0041-20261129-190402", {});
  make("dive-x99", {});
  make("holiday-0077", {});
  EXPECT_THAT(new_dive(dives).filename().string(), StartsWith("dive-0042"));
  make("dive-12345", {});
  EXPECT_THAT(new_dive(dives).filename().string(), StartsWith("dive-12346"));
  EXPECT_THAT(new_dive(dives / "none").filename().string(), StartsWith("dive-0001"));
}

TEST_F(EarlierDives, ThoseThatWereCutOffAreFoundInTheirOrder) {
  make("dive-0003", {"journal-00000.nadir"});
  make("dive-0001", {"journal-00000.nadir", "alerts.jsonl"});
  make("dive-0002", {"journal-00000.nadir", "dive.json"});
  make("dive-0004", {"holiday.jpg"});
  EXPECT_EQ(unfinished_dives(dives), (std::vector{dives / "dive-0001", dives / "dive-0003"}));
  EXPECT_TRUE(unfinished_dives(dives / "none").empty());
}

TEST_F(EarlierDives, OneThatCannotBeReadEndsNothing) {
  make("dive-0001", {"journal-00000.nadir", "journal-00001.nadir"});
  make("dive-0002", {"a", "b"});
  make("dive-0003", {"journal-00000.nadir"});
  const support::FailingFolder failing(dives / "dive-0002");
  EXPECT_EQ(unfinished_dives(dives), (std::vector{dives / "dive-0001", dives / "dive-0003"}));
}

}  // namespace
}  // namespace nadir::app
