// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "plain_text.hpp"

#include <gtest/gtest.h>

namespace nadir::app {
namespace {

TEST(PlainText, KeepsWhatPeopleWrite) {
  EXPECT_EQ(plain_text("Jože, 潜水 🐟", 40), "Jože, 潜水 🐟");
  EXPECT_EQ(plain_text("", 40), "");
}

TEST(PlainText, CountsCharactersNotBytes) {
  EXPECT_EQ(plain_text("潜水潜水", 3), "潜水潜");
  EXPECT_EQ(plain_text(std::string(1000, 'x'), 40), std::string(40, 'x'));
}

TEST(PlainText, LeavesOutWhatSteersATerminalOrTurnsWriting) {
  EXPECT_EQ(plain_text("a\r\nX: b\x1b[31m\x7f\xc2\x9b", 40), "a X: b[31m");
  EXPECT_EQ(plain_text(std::string_view("a\0b", 3), 40), "ab");
  EXPECT_EQ(plain_text("a\xe2\x80\xae"
                       "b\xe2\x81\xa6\xe2\x80\xa8",
                       40),
            "ab");
  EXPECT_EQ(plain_text(" \n a \t ", 40), "a");
}

TEST(PlainText, LeavesOutWhatIsNoUtf8) {
  EXPECT_EQ(plain_text("a\xc0\xaf\xff"
                       "b",
                       40),
            "ab");  // overlong
  EXPECT_EQ(plain_text("\xed\xa0\x80"
                       "a",
                       40),
            "a");  // surrogate
  EXPECT_EQ(plain_text("\xf4\x90\x80\x80"
                       "a",
                       40),
            "a");                               // beyond the last
  EXPECT_EQ(plain_text("a\xe2\x82", 40), "a");  // cut off
  EXPECT_EQ(plain_text("\xf0\x80\x80\xaf"
                       "a",
                       40),
            "a");
}

TEST(PercentDecoded, UndoesWhatAPageDidToATextAndNothingElse) {
  EXPECT_EQ(percent_decoded("Jo%C5%BEe%20%0d%0aX"), "Jože \r\nX");
  EXPECT_EQ(percent_decoded("100% %g1 %4"), "100% %g1 %4");
  EXPECT_EQ(percent_decoded("%2541"), "%41");
  EXPECT_EQ(percent_decoded("%"), "%");
}

}  // namespace
}  // namespace nadir::app
