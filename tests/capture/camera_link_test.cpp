// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A camera of a script in place of a driver: every order of events, at any time. The real ones are
// in v4l2_camera_test.
#include "camera_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

namespace nadir::capture {
namespace {

constexpr Time kMillisecond = 1'000'000;
constexpr Time kSecond = 1000 * kMillisecond;
using testing::HasSubstr;

/// What the camera does next; outlives it.
struct Script {
  std::deque<Picture> pictures;
  std::string gone, fault;
  std::vector<std::string> remarks;
  int opened = 0, open = 0;
};

class ScriptedCamera : public Camera {
 public:
  explicit ScriptedCamera(Script& script) : script_(script) { ++script_.open; }
  ~ScriptedCamera() override { --script_.open; }
  int descriptor() const override { return 0; }
  double rate_hz() const override { return 10; }
  Taken take() override {
    if (!script_.pictures.empty()) {
      Taken taken{std::move(script_.pictures.front()), {}};
      script_.pictures.pop_front();
      return taken;
    }
    return {{}, script_.gone};
  }

 private:
  Script& script_;
};

class CameraLinkTest : public testing::Test {
 protected:
  void give(Time time, std::uint32_t lost_before = 0) {
    Picture picture;
    picture.time = time;
    picture.lost_before = lost_before;
    script.pictures.push_back(picture);
  }
  std::vector<AlertKind> kinds() const {
    std::vector<AlertKind> all;
    for (const Alert& alert : alerts) all.push_back(alert.kind);
    return all;
  }

  Script script;
  std::vector<Alert> alerts;
  CameraLink link{"camera", [this] {
                    ++script.opened;
                    OpenedCamera opened;
                    if (script.fault.empty())
                      opened.camera = std::make_unique<ScriptedCamera>(script);
                    opened.fault = script.fault;
                    opened.remarks = script.remarks;
                    return opened;
                  }};
};

TEST_F(CameraLinkTest, TellsOnceThatThereIsNoCameraAndLooksForItAllTheTime) {
  script.fault = "there is no USB camera";
  Time now = 0;
  for (; now < 10 * kSecond; now += 50 * kMillisecond) link.keep_open(now, alerts);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_EQ(alerts[0].kind, AlertKind::camera_lost);
  EXPECT_THAT(alerts[0].message, HasSubstr("camera: there is no USB camera"));
  EXPECT_GE(script.opened, 10);  // at least every second
  EXPECT_LE(script.opened, 15);
  script.fault.clear();
  now = link.due();
  link.keep_open(now, alerts);
  EXPECT_TRUE(link.is_open());
  EXPECT_EQ(alerts.size(), 1u);  // it may give none
  give(now);
  EXPECT_TRUE(link.take(now, alerts));
  EXPECT_EQ(kinds(), (std::vector{AlertKind::camera_lost, AlertKind::camera_back}));
}

TEST_F(CameraLinkTest, TellsWithinASecondThatACameraWasUnplugged) {
  link.keep_open(0, alerts);
  for (Time t = 1; t < kSecond; t += 100 * kMillisecond) {
    give(t);
    EXPECT_TRUE(link.take(t, alerts));
  }
  EXPECT_TRUE(alerts.empty());
  script.gone = "No such device";
  script.fault = "/dev/video0: No such file or directory";
  EXPECT_FALSE(link.take(kSecond, alerts));
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_THAT(alerts[0].message, HasSubstr("No such device"));
  EXPECT_FALSE(link.is_open());
  EXPECT_EQ(script.open, 0);
  EXPECT_EQ(link.descriptor(), -1);
}

TEST_F(CameraLinkTest, StartsACameraAgainThatHasGivenNothingForThreePeriods) {
  link.keep_open(0, alerts);
  for (Time t = 1; t <= 4 * kSecond; t += 500 * kMillisecond) {  // slower than it says
    give(t);
    EXPECT_TRUE(link.take(t, alerts));
    link.keep_open(t + 499 * kMillisecond, alerts);
  }
  EXPECT_TRUE(alerts.empty());
  EXPECT_EQ(script.opened, 1);
  const Time silent = 3500 * kMillisecond + 3 * 500 * kMillisecond;
  link.keep_open(silent - kMillisecond, alerts);
  EXPECT_TRUE(alerts.empty());
  link.keep_open(silent + kMillisecond, alerts);
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_FALSE(link.is_open());
  link.keep_open(link.due(), alerts);
  EXPECT_TRUE(link.is_open());
  EXPECT_EQ(script.opened, 2);
}

TEST_F(CameraLinkTest, WaitsLongerForTheFirstPicture) {
  link.keep_open(0, alerts);
  link.keep_open(2900 * kMillisecond, alerts);
  EXPECT_TRUE(alerts.empty());
  link.keep_open(3 * kSecond, alerts);
  EXPECT_EQ(kinds(), (std::vector{AlertKind::camera_lost}));
}

TEST_F(CameraLinkTest, PassesOverPicturesThatAreNotLater) {
  link.keep_open(0, alerts);
  give(100);
  give(100);
  give(90);
  give(101);
  EXPECT_EQ(link.take(200, alerts)->time, 100);
  EXPECT_EQ(link.take(200, alerts)->time, 101);
  EXPECT_FALSE(link.take(200, alerts));
}

TEST_F(CameraLinkTest, IsNotBlindedByAPictureFromTheFuture) {
  constexpr Time kHour = 3600 * kSecond, kYears = 50'000 * kHour;
  Time now = 0;
  const auto take = [&](Time time, std::uint32_t lost_before) {
    give(time, lost_before);
    auto picture = link.take(now, alerts);
    link.keep_open(now, alerts);
    return picture;
  };
  link.keep_open(now, alerts);
  for (int i = 1; i <= 40; ++i) {
    now = i * 100 * kMillisecond;
    if (i % 10 == 5) {
      const auto early = take(now + (i == 5 ? kYears : kHour), UINT32_MAX);
      ASSERT_TRUE(early) << i;
      EXPECT_THAT(early->fault, HasSubstr("later than now"));
      EXPECT_EQ(early->lost_before, 0u);
    }
    const auto picture = take(now, 0);
    ASSERT_TRUE(picture) << i;
    EXPECT_EQ(picture->fault, "");
    EXPECT_EQ(link.period(), 100 * kMillisecond);
    EXPECT_LT(link.due(), now + kSecond);
  }
  EXPECT_TRUE(alerts.empty());
  EXPECT_EQ(script.opened, 1);
}

TEST_F(CameraLinkTest, StartsACameraAgainWhosePicturesAreAllFromTheFuture) {
  link.keep_open(0, alerts);
  for (Time t = 1; t < 3 * kSecond; t += 100 * kMillisecond) {
    give(t + 2 * kSecond);
    EXPECT_TRUE(link.take(t, alerts));
    link.keep_open(t, alerts);
  }
  EXPECT_TRUE(alerts.empty());
  link.keep_open(3 * kSecond, alerts);
  EXPECT_EQ(kinds(), (std::vector{AlertKind::camera_lost}));
}

TEST_F(CameraLinkTest, ForgetsAStampAheadWhenTheCameraIsOpenedAgain) {
  link.keep_open(0, alerts);
  give(100 + 900 * kMillisecond);
  EXPECT_TRUE(link.take(100, alerts));
  script.gone = "No such device";
  EXPECT_FALSE(link.take(200, alerts));
  script.gone.clear();
  const Time now = link.due();
  link.keep_open(now, alerts);
  give(now - 1);  // one from before is old
  give(now + 1);
  const auto picture = link.take(now + 2, alerts);
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->time, now + 1);
}

TEST_F(CameraLinkTest, BearsAnyNumberOfLostPictures) {
  link.keep_open(0, alerts);
  give(1);
  EXPECT_TRUE(link.take(1, alerts));
  give(100 * kMillisecond, UINT32_MAX);
  EXPECT_TRUE(link.take(100 * kMillisecond, alerts));
}

TEST_F(CameraLinkTest, TakesDamagedPicturesForNoSignOfHealth) {
  link.keep_open(0, alerts);
  for (Time t = 1; t < 3 * kSecond; t += 100 * kMillisecond) {
    give(t);
    script.pictures.back().fault = "no JPEG";
    EXPECT_TRUE(link.take(t, alerts));
    link.keep_open(t, alerts);
  }
  EXPECT_TRUE(alerts.empty());
  link.keep_open(3 * kSecond, alerts);
  EXPECT_EQ(kinds(), (std::vector{AlertKind::camera_lost}));
}

TEST_F(CameraLinkTest, IsNotHeldUpByADriverThatRepeatsItself) {
  link.keep_open(0, alerts);
  give(100);
  EXPECT_TRUE(link.take(200, alerts));
  for (int i = 0; i < 1000; ++i) give(100);
  EXPECT_FALSE(link.take(200, alerts));
  EXPECT_GT(script.pictures.size(), 900u);
  script.pictures.clear();
  for (int i = 0; i < 1000; ++i) give(10 * kSecond);
  EXPECT_TRUE(link.take(200, alerts));  // one from the future, once
  EXPECT_FALSE(link.take(200, alerts));
  EXPECT_GT(script.pictures.size(), 900u);
}

TEST_F(CameraLinkTest, MeasuresThePeriodAcrossLostPictures) {
  link.keep_open(0, alerts);
  for (int i = 0; i < 60; ++i) {
    give(i * 100 * kMillisecond, i == 0 ? 0 : 1);  // of 20 Hz every other is lost
    EXPECT_TRUE(link.take(i * 100 * kMillisecond, alerts));
  }
  EXPECT_NEAR(static_cast<double>(link.period()), 50e6, 1e6);
}

TEST_F(CameraLinkTest, TellsWhatACameraWouldNotBeSetTo) {
  script.remarks = {"/dev/video0: its focus cannot be set to 10"};
  link.keep_open(0, alerts);
  give(1);
  EXPECT_TRUE(link.take(1, alerts));
  ASSERT_EQ(alerts.size(), 1u);
  EXPECT_THAT(alerts[0].message, HasSubstr("focus"));
  EXPECT_THAT(alerts[0].remedy, HasSubstr("setting"));
}

}  // namespace
}  // namespace nadir::capture
