// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace nadir::app {
namespace {

using namespace std::chrono_literals;

TEST(Commands, AreTakenOnceAndOnlyWhenAccepted) {
  Commands commands;
  const std::stop_source stop;
  EXPECT_FALSE(commands.give(PageCommand::begin_dive));
  commands.accept({PageCommand::begin_dive, PageCommand::shut_down});
  EXPECT_FALSE(commands.give(PageCommand::end_dive));
  EXPECT_TRUE(commands.give(PageCommand::begin_dive));
  EXPECT_FALSE(commands.give(PageCommand::begin_dive)) << "a hand that presses twice";
  EXPECT_FALSE(commands.give(PageCommand::shut_down)) << "one after the other";
  EXPECT_EQ(commands.take(stop.get_token(), 5s), PageCommand::begin_dive);
  EXPECT_EQ(commands.take(stop.get_token(), 0s), std::nullopt);
  EXPECT_FALSE(commands.give(PageCommand::shut_down)) << "until it was done";
  commands.accept({PageCommand::end_dive, PageCommand::new_submap});
  EXPECT_FALSE(commands.give(PageCommand::begin_dive));
  EXPECT_TRUE(commands.give(PageCommand::new_submap));
}

TEST(Commands, ThatAreNoLongerAcceptedAreForgotten) {
  Commands commands;
  commands.accept({PageCommand::end_dive});
  EXPECT_TRUE(commands.give(PageCommand::end_dive));
  commands.accept({PageCommand::begin_dive});
  EXPECT_EQ(commands.take({}, 0s), std::nullopt);
}

TEST(Commands, WakeWhoWaitsAndAStopDoesToo) {
  Commands commands;
  commands.accept({PageCommand::end_dive});
  std::stop_source stop;
  std::optional<PageCommand> first, second;
  std::thread waits([&] {
    first = commands.take(stop.get_token(), 1h);
    second = commands.take(stop.get_token(), 1h);
  });
  EXPECT_TRUE(commands.give(PageCommand::end_dive));
  stop.request_stop();
  waits.join();
  EXPECT_EQ(first, PageCommand::end_dive);
  EXPECT_EQ(second, std::nullopt);
}

}  // namespace
}  // namespace nadir::app
