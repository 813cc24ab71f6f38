// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "answer_rules.hpp"

#include <gtest/gtest.h>

namespace nadir::serve {
namespace {

TEST(AnswerRules, CutOneRangeOutOfAFile) {
  EXPECT_EQ(part_of("", 100), (Part{0, 100}));
  EXPECT_EQ(part_of("bytes=0-9", 100), (Part{0, 10}));
  EXPECT_EQ(part_of("bytes=40-", 100), (Part{40, 100}));
  EXPECT_EQ(part_of("bytes=90-1000", 100), (Part{90, 100}));
  EXPECT_EQ(part_of("bytes=-5", 100), (Part{95, 100}));
  EXPECT_EQ(part_of("bytes=-500", 100), (Part{0, 100}));
  EXPECT_EQ(part_of("bytes=5-18446744073709551615", 100), (Part{5, 100}));
  EXPECT_EQ(part_of("", 0), (Part{0, 0}));
}

TEST(AnswerRules, GiveTheWholeForWhatIsNoSingleRange) {
  for (const auto* range : {"bytes=", "bytes=-", "bytes=a-b", "bytes=5", "bytes=9-5",
                            "bytes=0-1,5-6", "lines=1-2", "bytes= 1-2", "bytes=+1-2", "bytes=--5",
                            "bytes=1-2-3", "bytes=0x1-", "bytes=99999999999999999999-"}) {
    EXPECT_EQ(part_of(range, 100), (Part{0, 100})) << range;
  }
}

TEST(AnswerRules, RefuseARangeBeyondTheEnd) {
  for (const auto* range : {"bytes=100-", "bytes=100-200", "bytes=-0"}) {
    EXPECT_EQ(part_of(range, 100), std::nullopt) << range;
  }
  EXPECT_EQ(part_of("bytes=0-", 0), std::nullopt);
  EXPECT_EQ(part_of("bytes=-1", 0), std::nullopt);
}

TEST(AnswerRules, ResumeOnlyWhatHasNotChanged) {
  EXPECT_TRUE(is_unchanged("", "a-1"));
  EXPECT_TRUE(is_unchanged("\"a-1\"", "a-1"));
  EXPECT_FALSE(is_unchanged("\"a-2\"", "a-1"));
  EXPECT_FALSE(is_unchanged("a-1", "a-1"));
  EXPECT_FALSE(is_unchanged("W/\"a-1\"", "a-1"));
  EXPECT_FALSE(is_unchanged("\"\"", ""));
  EXPECT_FALSE(is_unchanged("Wed, 21 Oct 2015 07:28:00 GMT", "a-1"));
}

TEST(AnswerRules, NameAFileInWhatNoFieldCanBeBrokenWith) {
  EXPECT_EQ(attachment("mosaic-000.png"), "attachment; filename=\"mosaic-000.png\"");
  EXPECT_EQ(attachment("a\"b\r\nX: y/../\xc3\xa9"), "attachment; filename=\"a_b__X__y_..___\"");
}

}  // namespace
}  // namespace nadir::serve
