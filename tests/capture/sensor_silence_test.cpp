// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_silence.hpp"

#include <gtest/gtest.h>

#include "survey_folder.hpp"

namespace nadir::capture {
namespace {

struct Dive {
  SensorLog log = [] {
    const SurveyFolder folder;
    folder.write("depth.csv", "seconds,depth\n0,3\n");
    return SensorLog(folder.root() / "depth.csv", {{"depth", 0, 100}});
  }();
  SensorSilence silence;
  Frame frame;

  /// How many images were told of.
  int see(int images, double hz, bool has_value) {
    int told = 0;
    for (int i = 0; i < images; ++i) {
      told += silence.observe(frame, has_value, "depth.csv", log) ? 1 : 0;
      ++frame.image;
      frame.time += from_seconds(1 / hz);
    }
    return told;
  }
};

TEST(SensorSilence, ManyImagesOverSomeSecondsAreToldOnce) {
  Dive slow, film;
  EXPECT_EQ(slow.see(9, 1, false), 0);
  EXPECT_EQ(slow.see(50, 1, false), 1);
  EXPECT_EQ(film.see(49, 10, false), 0);
  EXPECT_EQ(film.see(50, 10, false), 1);
}

TEST(SensorSilence, FinishTellsOnlyOfASensorThatNeverSaidAnythingAndWasNotTold) {
  Dive none, never, told, once;
  EXPECT_FALSE(none.silence.finish("depth.csv", none.log));
  never.see(3, 1, false);
  const auto alert = never.silence.finish("depth.csv", never.log);
  ASSERT_TRUE(alert);
  EXPECT_EQ(alert->image, 2u);
  EXPECT_EQ(alert->time, from_seconds(2));
  EXPECT_FALSE(never.silence.finish("depth.csv", never.log));
  told.see(20, 1, false);
  EXPECT_FALSE(told.silence.finish("depth.csv", told.log));
  once.see(1, 1, true);
  once.see(3, 1, false);
  EXPECT_FALSE(once.silence.finish("depth.csv", once.log));
}

}  // namespace
}  // namespace nadir::capture
