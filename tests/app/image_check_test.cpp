// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "image_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nadir::app {
namespace {

using testing::HasSubstr;

TEST(ImageCheck, AsksForTheRateThatIsWanted) {
  EXPECT_EQ(check_rate(9.5, 10).verdict, Verdict::good);
  EXPECT_EQ(check_rate(3, 0).verdict, Verdict::good);
  EXPECT_EQ(check_rate(6, 10).verdict, Verdict::doubtful);
}

TEST(ImageCheck, SaysWhatToDoAboutThePicture) {
  Health health;
  for (const Finding& finding : check_picture(health)) EXPECT_EQ(finding.verdict, Verdict::good);
  health.add(Weakness::dark);
  EXPECT_THAT(check_picture(health)[0].remedy, HasSubstr("more light"));
  health = {};
  health.add(Weakness::bright);
  EXPECT_THAT(check_picture(health)[0].remedy, HasSubstr("less light"));
  health.add(Weakness::blurred);
  EXPECT_EQ(check_picture(health)[1].verdict, Verdict::doubtful);
}

TEST(ImageCheck, TellsBlurInPixels) {
  Health health;
  EXPECT_EQ(blur_px(health, 20), 10);  // nothing at all to see
  health.sharpness = 20;
  EXPECT_DOUBLE_EQ(blur_px(health, 20), 1);
  health.sharpness = 320;
  EXPECT_DOUBLE_EQ(blur_px(health, 20), 0.25);
  EXPECT_DOUBLE_EQ(motion_blur_px(150, 8), 1.2);
}

TEST(ImageCheck, BoundsTheSkewBothWays) {
  EXPECT_EQ(check_skew({}, 2).verdict, Verdict::doubtful);
  EXPECT_EQ(check_skew(from_seconds(-0.0019), 2).verdict, Verdict::good);
  EXPECT_EQ(check_skew(from_seconds(-0.0021), 2).verdict, Verdict::doubtful);
}

TEST(ImageCheck, JudgesAPairByItsEpipolarLines) {
  EXPECT_EQ(check_pair({.matches = 200, .allowed = 190, .epipolar_px = 0.4}).verdict,
            Verdict::good);
  EXPECT_EQ(check_pair({.matches = 200, .allowed = 190, .epipolar_px = 2}).verdict,
            Verdict::doubtful);
  EXPECT_EQ(check_pair({.matches = 200, .allowed = 10, .epipolar_px = 9}).verdict, Verdict::bad);
  EXPECT_EQ(check_pair({.matches = 3}).verdict, Verdict::doubtful);
}

TEST(ImageCheck, TellsWhatTheSensorsKnow) {
  Frame frame;
  EXPECT_EQ(check_vehicle(frame, "").verdict, Verdict::absent);
  EXPECT_EQ(check_vehicle(frame, "nmea:udp:2000").verdict, Verdict::doubtful);
  frame.attitude = Attitude{0, 0.1, -0.5};
  frame.depth = 12.34;
  const Finding finding = check_vehicle(frame, "nmea:udp:2000");
  EXPECT_EQ(finding.verdict, Verdict::good);
  EXPECT_EQ(finding.found, "roll 0, pitch 6, heading 331 degrees, depth 12.3 m");
}

}  // namespace
}  // namespace nadir::app
