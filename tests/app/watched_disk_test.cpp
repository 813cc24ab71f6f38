// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "watched_disk.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "support/dive_folder.hpp"

namespace nadir::app {
namespace {

using record::Disk;

TEST(WatchedDisk, TellsOfEveryCallThatComesBack) {
  const support::fs::path folder = support::fresh_folder("watched");
  support::fs::create_directories(folder.parent_path());
  pipeline::Progress progress;
  pipeline::Progress::of_this_thread() = &progress;
  WatchedDisk disk;
  int file = -1;
  const std::vector<std::function<bool()>> calls{
      [&] { return disk.make_directory(folder) == 0; },
      [&] { return (file = disk.open(folder / "a", Disk::Open::fresh)) >= 0; },
      [&] { return disk.write(file, record::as_bytes("bytes")) == 5; },
      [&] { return disk.sync(file) == 0; },
      [&] { return disk.sync_all(file) == 0; },
      [&] { return disk.close(file) == 0; },
      [&] { return disk.rename(folder / "a", folder / "b") == 0; },
      [&] { return disk.remove(folder / "b") == 0; },
      [&] { return disk.remove(folder) == 0; },
  };
  for (std::size_t i = 0; i < calls.size(); ++i) {
    progress.end();
    EXPECT_TRUE(calls[i]()) << i;
    EXPECT_TRUE(progress.busy(pipeline::Progress::Clock::now())) << i;
  }
  pipeline::Progress::of_this_thread() = nullptr;
}

}  // namespace
}  // namespace nadir::app
