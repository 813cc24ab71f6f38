// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "ladder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/failing_folder.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

class LadderTest : public testing::Test {
 protected:
  /// The step after so many seconds under a load.
  Economy after(int seconds, const Load& load) {
    Economy economy{};
    for (int s = 0; s < seconds; ++s) economy = ladder.observe(now += 1s, load);
    return economy;
  }

  Ladder ladder;
  Ladder::Clock::time_point now{1h};
};

TEST_F(LadderTest, GivesUpOneThingAfterTheOtherAndTakesThemBack) {
  Load load;
  load.dropped = 0.3;
  EXPECT_EQ(after(5, load), Economy::none);  // images at a start, or one slow adjustment
  EXPECT_EQ(after(2, load), Economy::live_image);
  EXPECT_THAT(ladder.reason(), HasSubstr("30 %"));
  EXPECT_EQ(after(8, load), Economy::live_image);  // does it help?
  EXPECT_EQ(after(3, load), Economy::mosaic);
  EXPECT_EQ(after(11, load), Economy::projection);
  EXPECT_EQ(after(100, load), Economy::projection);
  load.dropped = 0.02;  // neither good nor bad
  EXPECT_EQ(after(200, load), Economy::projection);
  load.dropped = 0;
  EXPECT_EQ(after(59, load), Economy::projection);
  EXPECT_EQ(after(3, load), Economy::mosaic);
  EXPECT_EQ(after(61, load), Economy::live_image);
  EXPECT_EQ(after(61, load), Economy::none);
}

TEST_F(LadderTest, BearsAMomentOfTooMuch) {
  Load good, bad;
  bad.dropped = 0.5;
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(after(4, bad), Economy::none);
    EXPECT_EQ(after(2, good), Economy::none);
  }
}

TEST_F(LadderTest, KnowsEachLimitAndNamesIt) {
  const auto reason_for = [&](auto change) {
    ladder = Ladder();
    Load load;
    change(load);
    EXPECT_EQ(after(10, load), Economy::live_image);
    return ladder.reason();
  };
  EXPECT_THAT(reason_for([](Load& l) { l.temperature_deg = 84; }), HasSubstr("84 degrees"));
  EXPECT_THAT(reason_for([](Load& l) { l.throttling = {.slowed_down = true}; }),
              HasSubstr("supply"));
  EXPECT_THAT(reason_for([](Load& l) { l.memory = 0.9; }), HasSubstr("90 % of the memory"));
  EXPECT_THAT(reason_for([](Load& l) { l.free_disk_gb = 0.4; }), HasSubstr("disk"));
  EXPECT_THAT(reason_for([](Load& l) { l.battery = 0.1; }), HasSubstr("battery has 10 %"));
}

TEST(BoardLoad, ReadsWhatTheKernelTells) {
  std::string name = testing::TempDir() + "nadir-sys-XXXXXX";
  const fs::path sys = mkdtemp(name.data());
  Load load = board_load(sys, sys);
  EXPECT_FALSE(load.temperature_deg);
  EXPECT_FALSE(load.battery);
  EXPECT_FALSE(load.throttling);
  ASSERT_TRUE(load.free_disk_gb);
  EXPECT_NEAR(*load.free_disk_gb, 1e-9 * static_cast<double>(fs::space(sys).available), 0.5);
  const auto write = [&](const fs::path& file, const std::string& text) {
    fs::create_directories((sys / file).parent_path());
    std::ofstream(sys / file) << text;
  };
  write("class/thermal/thermal_zone0/temp", "61250\n");
  write("class/thermal/thermal_zone1/temp", "81500\n");
  write("class/power_supply/battery/capacity", "37\n");
  write("class/power_supply/usb/online", "1\n");
  write("devices/platform/soc/soc:firmware/get_throttled", "50005\n");
  load = board_load(sys, sys);
  EXPECT_EQ(load.temperature_deg, 81.5);
  EXPECT_EQ(load.battery, 0.37);
  ASSERT_TRUE(load.throttling);
  EXPECT_TRUE(load.throttling->weak_supply);
  EXPECT_TRUE(load.throttling->slowed_down);
  fs::remove_all(sys / "devices/platform/soc");
  write("devices/platform/soc@107c000000/soc@107c000000:firmware/get_throttled", "4\n");
  load = board_load(sys, sys);
  ASSERT_TRUE(load.throttling);
  EXPECT_FALSE(load.throttling->weak_supply);
  EXPECT_TRUE(load.throttling->slowed_down);
  fs::remove_all(sys / "devices/platform");
  for (const char* other : {"cooling", "leds"})
    write(fs::path("devices/platform") / other / "a", "1\n");
  {
    const support::FailingFolder failing(sys / "devices/platform");
    EXPECT_EQ(board_load(sys, sys).temperature_deg, 81.5);
  }
  fs::remove_all(sys);
}

}  // namespace
}  // namespace nadir::app
