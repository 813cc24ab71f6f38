// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "board_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class BoardCheck : public testing::Test {
 protected:
  BoardCheck() {
    std::string name = testing::TempDir() + "nadir-board-check-XXXXXX";
    folder = mkdtemp(name.data());
  }
  ~BoardCheck() override { fs::remove_all(folder); }

  fs::path folder;
};

std::optional<Finding> item_of(const Load& load, const std::string& item) {
  const auto findings = check_board(load);
  const auto found = std::ranges::find(findings, item, &Finding::item);
  return found == findings.end() ? std::nullopt : std::optional(*found);
}

TEST_F(BoardCheck, MeasuresTheDiskAndLeavesNothing) {
  const Finding finding = check_disk_speed(folder / "dives");
  EXPECT_EQ(finding.item, "disk speed");
  EXPECT_GT(std::stod(finding.found), 0);
  EXPECT_TRUE(fs::is_empty(folder));  // nor makes the folder
}

TEST_F(BoardCheck, MeasuresAPartWhenThatIsEnough) {
  std::stop_source enough;
  enough.request_stop();
  EXPECT_GT(std::stod(check_disk_speed(folder, enough.get_token()).found), 0);
}

TEST_F(BoardCheck, WritesThroughNoLink) {
  std::ofstream(folder / "victim") << "precious";
  fs::create_symlink(folder / "victim", folder / ".speed-test");
  EXPECT_EQ(check_disk_speed(folder).item, "disk speed");
  EXPECT_EQ(fs::file_size(folder / "victim"), 8u);
}

TEST_F(BoardCheck, CallsADiskBadThatCannotBeWritten) {
  std::ofstream(folder / "file") << "x";
  const Finding finding = check_disk_speed(folder / "file" / "dives");
  EXPECT_EQ(finding.verdict, Verdict::bad);
  EXPECT_THAT(finding.found, HasSubstr("Not a directory"));
}

TEST_F(BoardCheck, SaysWhatIsNotMeasured) {
  const auto findings = check_board({});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::absent);
}

TEST_F(BoardCheck, JudgesHeatSupplySpaceAndBattery) {
  Load load{
      .temperature_deg = 52.9, .throttling = Throttling{}, .free_disk_gb = 30, .battery = 0.8};
  for (const Finding& finding : check_board(load)) EXPECT_EQ(finding.verdict, Verdict::good);
  EXPECT_EQ(item_of(load, "temperature")->found, "53 degrees");
  load = {.temperature_deg = 81,
          .throttling = Throttling{.weak_supply = true},
          .free_disk_gb = 1,
          .battery = 0.2};
  const auto findings = check_board(load);
  EXPECT_EQ(findings.size(), 4u);
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.verdict, Verdict::doubtful) << finding.item;
    EXPECT_NE(finding.remedy, "") << finding.item;
  }
  EXPECT_THAT(item_of(load, "throttling")->found, HasSubstr("voltage"));
  load.throttling = Throttling{.slowed_down = true};
  EXPECT_THAT(item_of(load, "throttling")->found, HasSubstr("heat"));
}

}  // namespace
}  // namespace nadir::app
