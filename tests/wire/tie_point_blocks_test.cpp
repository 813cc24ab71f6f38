// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/wire/tie_point_blocks.hpp"

#include <gmock/gmock.h>

namespace nadir::wire {
namespace {

TiePoint point(std::uint64_t id, double x) {
  return {.id = id, .x_in_survey = {x, 2e6, 3}, .rgb = {10, 20, 30}};
}

double x_of(const TiePoints& block, std::size_t i) {
  return block.origin.x() + static_cast<double>(block.points[i].offset[0]);
}

TEST(TiePointBlocks, SplitPointsByTheirIdsInAscendingOrder) {
  TiePointBlocks blocks;
  const auto changed = blocks.update(
      std::vector{point(kTiePointBlock + 4, 1), point(7, 2), point(kTiePointBlock + 1, 3)});
  ASSERT_EQ(changed.size(), 2U);
  EXPECT_EQ(changed[0].block, 0U);
  EXPECT_EQ(changed[0].points.at(0).index, 7);
  EXPECT_EQ(changed[1].block, 1U);
  EXPECT_EQ(changed[1].points.at(0).index, 1);
  EXPECT_EQ(changed[1].points.at(1).index, 4);
  EXPECT_NEAR(x_of(changed[1], 1), 1, 1e-6);
}

TEST(TiePointBlocks, ReturnTheWholeOfATouchedBlockAndNothingElse) {
  TiePointBlocks blocks;
  blocks.update(std::vector{point(1, 1), point(2, 2), point(5 * kTiePointBlock, 9)});
  const auto changed = blocks.update(std::vector{point(2, 2.5), point(3, 4)});
  ASSERT_EQ(changed.size(), 1U);
  ASSERT_EQ(changed[0].points.size(), 3U);
  EXPECT_NEAR(x_of(changed[0], 0), 1, 1e-6);
  EXPECT_NEAR(x_of(changed[0], 1), 2.5, 1e-6);
  EXPECT_NEAR(x_of(changed[0], 2), 4, 1e-6);
}

TEST(TiePointBlocks, LeaveOutWhatWasGivenUp) {
  TiePointBlocks blocks;
  blocks.update(std::vector{point(1, 1), point(2, 2), point(5 * kTiePointBlock, 9)});
  const std::uint64_t unknown = 9 * kTiePointBlock;
  const auto changed =
      blocks.update({}, std::vector<std::uint64_t>{1, 3, 5 * kTiePointBlock, unknown});
  ASSERT_EQ(changed.size(), 2U);
  ASSERT_EQ(changed[0].points.size(), 1U);
  EXPECT_EQ(changed[0].points[0].index, 2);
  EXPECT_TRUE(changed[1].points.empty());
  EXPECT_EQ(blocks.size(), 1U);
  EXPECT_TRUE(decode_tie_points(encode(changed[1])));
}

TEST(TiePointBlocks, KeepAMillimetreFarFromTheOrigin) {
  TiePointBlocks blocks;
  const auto changed = blocks.update(std::vector{point(0, 1e6), point(1, 1e6 + 10.001)});
  EXPECT_NEAR(x_of(changed.at(0), 1), 1e6 + 10.001, 1e-5);
}

}  // namespace
}  // namespace nadir::wire
