// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "nadir/core/check.hpp"
#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

using ::testing::HasSubstr;

class Csv : public ::testing::Test {
 protected:
  CsvReader reader(std::string_view content) {
    folder_.write("x.csv", content);
    return CsvReader(folder_.root() / "x.csv", {"seconds", "depth"});
  }
  std::string refusal(std::string_view content) {
    try {
      CsvReader csv = reader(content);
      while (csv.next()) (void)csv.number(1);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  SurveyFolder folder_;
};

TEST_F(Csv, FindsColumnsByNameThroughTheHabitsOfSpreadsheets) {
  CsvReader csv =
      reader("\xef\xbb\xbf Depth , note,\"Seconds\"\r\n\r\n# calm\r\n 3.5 ,x, +1e1 \r\n4,,");
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.number(0), 10);
  EXPECT_EQ(csv.number(1), 3.5);
  ASSERT_TRUE(csv.next());
  EXPECT_TRUE(std::isnan(csv.number(0)));
  EXPECT_EQ(csv.text(1), "4");
  EXPECT_FALSE(csv.next());
}

TEST_F(Csv, GivesNoNumberForWhatIsNotFinite) {
  for (const char* value : {"nan", "NaN", "inf", "-inf", "1e999", ""}) {
    CsvReader csv = reader(std::string("seconds,depth\n0,") + value + "\n");
    ASSERT_TRUE(csv.next());
    EXPECT_TRUE(std::isnan(csv.number(1))) << value;
  }
}

TEST_F(Csv, NamesFileAndLineOfAFault) {
  EXPECT_THAT(refusal("seconds,depth\n0,1\n1,deep\n"),
              HasSubstr("x.csv:3: \"deep\" is not a number"));
  EXPECT_THAT(refusal("seconds,depth\n0\n"), HasSubstr("x.csv:2: has too few values"));
  EXPECT_THAT(refusal("time,depth\n0,1\n"), HasSubstr("no column \"seconds\""));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("seconds,depth\n0,1,5 m\n1,1 m\n"), HasSubstr("x.csv:3"));
}

TEST_F(Csv, ReadsAHeaderAlone) { EXPECT_FALSE(reader("seconds,depth").next()); }

}  // namespace
}  // namespace nadir::capture
