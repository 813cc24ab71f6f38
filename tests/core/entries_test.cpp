// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/entries.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/failing_folder.hpp"

namespace nadir {
namespace {

TEST(Entries, AreThoseThatCanBeRead) {
  std::string name = testing::TempDir() + "nadir-entries-XXXXXX";
  const std::filesystem::path folder = mkdtemp(name.data());
  EXPECT_TRUE(entries_of(folder).empty());
  EXPECT_TRUE(entries_of(folder / "none").empty());
  std::ofstream(folder / "a") << "x";
  std::filesystem::create_directory(folder / "b");
  EXPECT_THAT(entries_of(folder), testing::UnorderedElementsAre(folder / "a", folder / "b"));
  EXPECT_TRUE(entries_of(folder / "a").empty());
  {
    const support::FailingFolder failing(folder);
    EXPECT_EQ(entries_of(folder).size(), 1u);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace nadir
