// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "config_file.hpp"
#include "nadir/core/check.hpp"

namespace nadir::app {
namespace {

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::filesystem::path file_with(const std::string& text) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("nadir-config-" + std::to_string(getpid()) + ".toml");
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

std::string error_of_file(const std::string& text) {
  return message_of([&] {
    Config config;
    read_config_file(file_with(text), config);
  });
}

TEST(Config, ShippedFileEqualsTheDump) {
  std::ifstream file(std::string(NADIR_SOURCE_DIR) + "/config/nadir.toml");
  std::ostringstream shipped;
  shipped << file.rdbuf();
  EXPECT_EQ(shipped.str(), dump(Config{})) << "nadir --dump-config > config/nadir.toml";
}

TEST(Config, DefaultsPassTheirOwnChecks) { EXPECT_NO_THROW(Config{}.check()); }

TEST(Config, EverySettingIsReadBackAsDumped) {
  Config changed;
  for (const Setting& setting : settings()) {
    const Value before = setting.get(changed);
    if (const bool* v = std::get_if<bool>(&before)) setting.set(changed, !*v);
    if (const auto* v = std::get_if<std::int64_t>(&before)) setting.set(changed, *v + 1);
    if (const auto* v = std::get_if<double>(&before); v && setting.key != "capture.scale")
      setting.set(changed, *v + 0.123456789);
  }
  Config read;
  read_config_file(file_with(dump(changed)), read);
  EXPECT_EQ(dump(read), dump(changed));
  EXPECT_NE(dump(read), dump(Config{}));
}

TEST(Config, NamesAreUniqueAndHaveAMeaning) {
  std::set<std::string> names;
  for (const Setting& setting : settings()) {
    EXPECT_TRUE(names.insert(setting.key).second) << setting.key;
    EXPECT_FALSE(setting.meaning.empty()) << setting.key;
  }
}

TEST(Config, UnknownKeyNamesPlaceAndNearestNeighbour) {
  const std::string error = error_of_file("[odometry]\nwindo = 5\n");
  EXPECT_NE(error.find(".toml:2:"), std::string::npos) << error;
  EXPECT_NE(error.find("'odometry.window'"), std::string::npos) << error;
}

TEST(Config, FaultsNameThePlaceAndTheRemedy) {
  EXPECT_NE(
      error_of_file("[odometry]\nwindow = 'five'\n").find("odometry.window wants a whole number"),
      std::string::npos);
  EXPECT_NE(error_of_file("[odometry]\nwindow = [5]\n").find("a setting is a number"),
            std::string::npos);
  EXPECT_NE(error_of_file("[odometry\n").find(":1:"), std::string::npos);
  EXPECT_NE(error_of_file("window = 5\n").find("belong below a [room]"), std::string::npos);
  EXPECT_NE(error_of_file("[odometry]\nwindow = 5\nwindow = 3\n").find(":3:"), std::string::npos);
  EXPECT_NE(error_of_file("[odometry]\non_lost = 'sink'\n").find("wants one of: stop, submap"),
            std::string::npos);
  EXPECT_NE(message_of([] {
              Config config;
              read_config_file("/nonexistent.toml", config);
            }).find("/nonexistent.toml"),
            std::string::npos);
}

TEST(Config, FilesThatAreNoSettingsAreRefused) {
  EXPECT_NE(error_of_file(std::string(2 << 20, '#')).find("more than 1 MB"), std::string::npos);
  std::string deep = "a";
  for (int i = 0; i < 40000; ++i) deep += ".a";
  EXPECT_NE(error_of_file("\n" + deep + " = 1\n").find(":2: the line has more than 4096"),
            std::string::npos);
  EXPECT_NE(message_of([] {
              Config config;
              read_config_file("/" + std::string(300, 'x'), config);
            }).find("too long"),
            std::string::npos);
}

TEST(Config, SensorsAreCheckedWithTheRest) {
  Config config;
  config.sensors.inputs = "foo";
  EXPECT_NE(message_of([&] { config.check(); }).find("\"foo\""), std::string::npos);
  config.sensors.inputs.clear();
  config.sensors.outputs = "bar";
  EXPECT_NE(message_of([&] { config.check(); }).find("\"bar\""), std::string::npos);
}

TEST(Config, WindowsLineEndsAndByteOrderMarkAreRead) {
  Config config;
  read_config_file(file_with("\xEF\xBB\xBF[odometry]\r\nwindow = 3\r\n"), config);
  EXPECT_EQ(config.odometry.window, 3);
}

TEST(Config, NumbersAreFinite) {
  for (const char* assignment : {"mosaic2d.restart_rms=inf", "plane.max_reprojection_px=nan",
                                 "reference.dead_reckoning_max_s=1e10"}) {
    Config config;
    read_assignment(assignment, config);
    const std::string key = std::string(assignment).substr(0, std::string(assignment).find('='));
    EXPECT_NE(message_of([&] { config.check(); }).find(key), std::string::npos) << assignment;
  }
}

TEST(Config, AssignmentsTakeNumbersAndBareWords) {
  Config config;
  read_assignment("odometry.window=3", config);
  read_assignment("odometry.on_lost=stop", config);
  read_assignment("capture.scale=0.5", config);
  EXPECT_EQ(config.odometry.window, 3);
  EXPECT_EQ(config.odometry.on_lost, odometry::OnLost::stop);
  EXPECT_NE(message_of([&] { read_assignment("odometry.window", config); }).find("room.key=value"),
            std::string::npos);
  EXPECT_NE(message_of([&] { read_assignment("odometry.window=big", config); }).find("--set"),
            std::string::npos);
}

}  // namespace
}  // namespace nadir::app
