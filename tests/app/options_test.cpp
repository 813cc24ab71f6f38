// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

Command parse(std::vector<const char*> words) {
  words.insert(words.begin(), "nadir");
  return parse_command_line(static_cast<int>(words.size()), words.data());
}

int status(const Command& command) {
  const auto* answered = std::get_if<Answered>(&command);
  return answered ? answered->status : -1;
}

TEST(Options, ReplayByDefaultLosesNothingAndServesNothing) {
  const Command command = parse({"replay", "survey", "--out", "dive"});
  const auto& replay = std::get<Replay>(command);
  EXPECT_EQ(replay.folder, "survey");
  EXPECT_EQ(replay.dive, "dive");
  EXPECT_EQ(replay.rate.kind, Rate::Kind::max);
  EXPECT_FALSE(replay.serve || replay.calibration || replay.settings.file || replay.keep_serving);
}

TEST(Options, ReplayTakesEveryOption) {
  const Command command =
      parse({"replay", "survey", "--out", "dive", "--calib", "c.yml", "--config", "n.toml", "--set",
             "capture.scale=0.5", "--set", "odometry.window=3", "--serve", "0.0.0.0:8765",
             "--keep-serving", "--rate", "2.5"});
  const auto& replay = std::get<Replay>(command);
  EXPECT_EQ(replay.calibration, "c.yml");
  EXPECT_EQ(replay.settings.file, "n.toml");
  EXPECT_EQ(replay.settings.assignments,
            (std::vector<std::string>{"capture.scale=0.5", "odometry.window=3"}));
  ASSERT_TRUE(replay.serve);
  EXPECT_EQ(replay.serve->host, "0.0.0.0");
  EXPECT_EQ(replay.serve->port, 8765);
  EXPECT_TRUE(replay.keep_serving);
  EXPECT_EQ(replay.rate.kind, Rate::Kind::fixed);
  EXPECT_EQ(replay.rate.hz, 2.5);
}

TEST(Options, ReplayTakesPosesOfOneOtherProgram) {
  EXPECT_EQ(std::get<Replay>(parse({"replay", "s", "--out", "d", "--poses", "t.tum"})).poses,
            "t.tum");
  EXPECT_EQ(std::get<Replay>(parse({"replay", "s", "--out", "d", "--colmap", "m"})).colmap, "m");
}

TEST(Options, CheckCalibrationTakesAFolderAndACalibration) {
  const Command command = parse({"check-calibration", "survey", "--calib", "c.yml"});
  const auto& check = std::get<CheckCalibration>(command);
  EXPECT_EQ(check.folder, "survey");
  EXPECT_EQ(check.calibration, "c.yml");
}

TEST(Options, WrongCommandLinesExitWithTwo) {
  const std::vector<std::vector<const char*>> wrong = {
      {},
      {"swim"},
      {"replay"},
      {"replay", "survey"},
      {"replay", "survey", "--out"},
      {"replay", "survey", "--out", "dive", "--rate", "fast"},
      {"replay", "survey", "--out", "dive", "--rate", "0"},
      {"replay", "survey", "--out", "dive", "--rate", "-1"},
      {"replay", "survey", "--out", "dive", "--rate", "nan"},
      {"replay", "survey", "--out", "dive", "--serve", "a:1", "--no-serve"},
      {"replay", "survey", "--out", "dive", "--keep-serving"},
      {"replay", "survey", "--out", "dive", "--poses", "a.tum", "--colmap", "model"},
      {"replay", "survey", "--out", "dive", "--poses", ""},
      {"replay", "survey", "--out", "dive", "--serve", "8765"},
      {"replay", "survey", "--out", "dive", "--serve", "localhost:99999"},
      {"replay", "survey", "--out", "dive", "--serve", "localhost:"},
      {"replay", "survey", "--out", "dive", "--depth", "3"},
      {"simulate", "--scene", "pool"},
      {"simulate", "--out", ""},
      {"simulate", "--out", "f", "--scene", "moon"},
      {"simulate", "--out", "f", "--images", "0"},
      {"simulate", "--out", "f", "--images", "10001"},
      {"simulate", "--out", "f", "--seed", "-3"},
      {"recover"},
      {"help", "swim"},
      {"--set", "a.b=c", "recover", "dive"},
  };
  for (const auto& words : wrong) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(status(parse(words)), 2) << testing::PrintToString(words);
    EXPECT_NE(testing::internal::GetCapturedStderr(), "") << testing::PrintToString(words);
  }
}

TEST(Options, HelpAndVersionAreAnsweredWithZero) {
  for (const auto& words : std::vector<std::vector<const char*>>{
           {"--help"}, {"--version"}, {"help"}, {"help", "replay"}, {"replay", "--help"}}) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(status(parse(words)), 0);
    EXPECT_NE(testing::internal::GetCapturedStdout(), "");
  }
}

TEST(Options, SimulateKnowsItsScenes) {
  const Command command = parse(
      {"simulate", "--out", "f", "--scene", "reef", "--images", "7", "--stereo", "--seed", "9"});
  const auto& simulate = std::get<Simulate>(command);
  EXPECT_EQ(simulate.scene, "reef");
  EXPECT_EQ(simulate.images, 7);
  EXPECT_TRUE(simulate.stereo);
  EXPECT_EQ(simulate.seed, 9u);
}

TEST(Options, DumpConfigTakesSettings) {
  const Command command = parse({"--dump-config", "--set", "capture.scale=0.25"});
  EXPECT_EQ(std::get<DumpConfig>(command).settings.assignments.size(), 1u);
}

}  // namespace
}  // namespace nadir::app
