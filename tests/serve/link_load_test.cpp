// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "link_load.hpp"

#include <gtest/gtest.h>

namespace nadir::serve {
namespace {

using namespace std::chrono_literals;

/// A record every 100 ms for so long, each written in that time.
void write(LinkLoad& load, LinkLoad::Clock::time_point& now, std::chrono::milliseconds each,
           std::chrono::seconds for_so_long) {
  const auto end = now + for_so_long;
  for (; now < end; now += 100ms) load.wrote(now, now + each);
}

TEST(LinkLoad, TellsAThinLinkFromAnAmpleOne) {
  LinkLoad::Clock::time_point now{};
  LinkLoad load(now);
  EXPECT_FALSE(load.is_thin());
  write(load, now, 5ms, 10s);
  EXPECT_FALSE(load.is_thin());
  write(load, now, 50ms, 10s);
  EXPECT_FALSE(load.is_thin()) << "it would carry twice as much";
  write(load, now, 99ms, 3s);
  EXPECT_TRUE(load.is_thin()) << "within three seconds";
  write(load, now, 5ms, 5s);
  EXPECT_FALSE(load.is_thin()) << "it has become better";
}

TEST(LinkLoad, DoesNotWaver) {
  LinkLoad::Clock::time_point now{};
  LinkLoad load(now);
  write(load, now, 60ms, 10s);
  EXPECT_FALSE(load.is_thin());
  write(load, now, 99ms, 5s);
  write(load, now, 60ms, 10s);
  EXPECT_TRUE(load.is_thin()) << "with a smaller image a thin link waits less";
}

TEST(LinkLoad, SeesOneLongWait) {
  LinkLoad::Clock::time_point now{};
  LinkLoad load(now);
  load.wrote(now, now + 3s);
  EXPECT_TRUE(load.is_thin());
}

}  // namespace
}  // namespace nadir::serve
