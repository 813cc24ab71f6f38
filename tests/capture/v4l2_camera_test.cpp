// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Against the kernel's virtual cameras; `./dev guest` runs it where they are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>

#include "camera.hpp"
#include "vivid.hpp"

namespace nadir::capture {
namespace {

using testing::HasSubstr;

std::ptrdiff_t open_files() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return std::distance(begin(files), end(files));
}

class V4l2CameraTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto nodes = vivid_nodes();
    if (nodes.empty()) GTEST_SKIP() << "not run: no virtual camera (modprobe vivid)";
    node = nodes.front();
    camera = open();
  }

  std::unique_ptr<Camera> open() const {
    OpenedCamera opened = open_v4l2(node, mode);
    EXPECT_EQ(opened.fault, "");
    return std::move(opened.camera);
  }

  /// Waits for it, some seconds at most.
  Camera::Taken next() const {
    pollfd waiting{camera->descriptor(), POLLIN | POLLPRI, 0};
    constexpr int kPatience_ms = 5000;
    ::poll(&waiting, 1, kPatience_ms);
    return camera->take();
  }

  CameraMode mode{640, 360, 10};
  std::string node;
  std::unique_ptr<Camera> camera;
};

TEST_F(V4l2CameraTest, GivesPicturesThatCanBeDecoded) {
  ASSERT_TRUE(camera);
  Camera::Taken taken = next();
  ASSERT_TRUE(taken.picture) << taken.gone;
  const Picture& picture = *taken.picture;
  EXPECT_EQ(picture.fault, "");
  ASSERT_TRUE(picture.encoding.raw);
  const auto decoded = image_io::decode_raw({*picture.encoding.raw, picture.encoding.order, 640,
                                             360, picture.encoding.stride, picture.bytes},
                                            1, image_io::Colour::bgr);
  ASSERT_EQ(decoded.fault, "");
  // Its bars are white, yellow, cyan and so on, from the left.
  const cv::Vec3b white = decoded.image.at<cv::Vec3b>(330, 40);
  const cv::Vec3b yellow = decoded.image.at<cv::Vec3b>(330, 120);
  EXPECT_GT(white[0], 150);
  EXPECT_LT(yellow[0], 80);
  EXPECT_GT(yellow[1], 150);
  EXPECT_GT(yellow[2], 150);
}

TEST_F(V4l2CameraTest, StampsPicturesByTheMonotonicClock) {
  ASSERT_TRUE(camera);
  EXPECT_NEAR(camera->rate_hz(), 10, 0.5);
  std::optional<Time> before;
  for (int i = 0; i < 10; ++i) {
    const Camera::Taken taken = next();
    ASSERT_TRUE(taken.picture) << taken.gone;
    const Time now = monotonic_now();
    EXPECT_LT(taken.picture->time, now + from_seconds(0.1));  // of its end, says the driver
    EXPECT_GT(taken.picture->time, now - from_seconds(1));
    if (before && taken.picture->lost_before == 0) {
      EXPECT_NEAR(seconds(taken.picture->time - *before), 0.1, 0.02);
    }
    before = taken.picture->time;
  }
}

TEST_F(V4l2CameraTest, CountsThePicturesThatTheDriverLost) {
  ASSERT_TRUE(camera);
  ASSERT_TRUE(next().picture);
  ASSERT_TRUE(set_vivid(node, "Percentage of Dropped Buffers", 50));
  const Time begin = next().picture->time;
  Time end = begin;
  std::uint32_t taken = 0, lost = 0;
  for (; taken < 30; ++taken) {
    const Camera::Taken one = next();
    ASSERT_TRUE(one.picture) << one.gone;
    lost += one.picture->lost_before;
    end = one.picture->time;
  }
  set_vivid(node, "Percentage of Dropped Buffers", 0);
  EXPECT_GT(lost, 5u);
  EXPECT_EQ(taken + lost, static_cast<std::uint32_t>(std::lround(10 * seconds(end - begin))));
}

TEST_F(V4l2CameraTest, CallsPicturesDamagedThatTheDriverDoes) {
  ASSERT_TRUE(camera);
  ASSERT_TRUE(next().picture);
  ASSERT_TRUE(set_vivid(node, "Inject V4L2_BUF_FLAG_ERROR", 1));
  bool damaged = false;
  for (int i = 0; i < 10 && !damaged; ++i) {
    const Camera::Taken taken = next();
    ASSERT_TRUE(taken.picture) << taken.gone;
    damaged = !taken.picture->fault.empty();
    EXPECT_EQ(damaged, taken.picture->bytes.empty());
  }
  EXPECT_TRUE(damaged);
}

TEST_F(V4l2CameraTest, EndsWhenTheCameraIsUnplugged) {
  ASSERT_TRUE(camera);
  ASSERT_TRUE(next().picture);
  ASSERT_TRUE(set_vivid(node, "Disconnect", 1));
  Camera::Taken taken = next();
  while (taken.picture) taken = next();  // those that were there already
  EXPECT_NE(taken.gone, "");
  camera.reset();
  camera = open();  // this driver plugs it in again when nobody has it open
  ASSERT_TRUE(camera);
  EXPECT_TRUE(next().picture);
  unplug_vivid();
  taken = next();
  while (taken.picture) taken = next();
  EXPECT_NE(taken.gone, "");
  camera.reset();
  EXPECT_NE(open_v4l2(node, mode).fault, "");
  plug_vivid();
  ASSERT_FALSE(vivid_nodes().empty());
  node = vivid_nodes().front();
  camera = open();
  ASSERT_TRUE(camera);
  EXPECT_TRUE(next().picture);
}

TEST_F(V4l2CameraTest, EndsAtAFatalErrorAndCanBeOpenedAgainAHundredTimes) {
  const std::ptrdiff_t files = open_files();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(camera) << i;
    ASSERT_TRUE(next().picture) << i;
    if (i % 10 == 0) {  // the rest is opened again while all is well
      ASSERT_TRUE(set_vivid(node, "Inject Fatal Streaming Error", 1));
      Camera::Taken taken = next();
      while (taken.picture) taken = next();
      EXPECT_NE(taken.gone, "");
    }
    camera.reset();
    camera = open();
  }
  EXPECT_EQ(open_files(), files);
}

TEST_F(V4l2CameraTest, SaysWhichCallTheDriverRefuses) {
  camera.reset();
  for (const char* fault : {"Inject VIDIOC_REQBUFS Error", "Inject VIDIOC_STREAMON Error"}) {
    ASSERT_TRUE(set_vivid(node, fault, 1)) << fault;
    EXPECT_THAT(open_v4l2(node, mode).fault, HasSubstr(node)) << fault;
    EXPECT_EQ(open_v4l2(node, mode).fault, "") << fault;  // it errs once
  }
}

TEST_F(V4l2CameraTest, LeavesACameraToTheProgramThatHasIt) {
  EXPECT_THAT(open_v4l2(node, mode).fault, HasSubstr("in use by another program"));
  EXPECT_TRUE(next().picture);
}

TEST_F(V4l2CameraTest, NamesTheSizesThereAre) {
  camera.reset();
  mode.width = 968;
  const std::string fault = open_v4l2(node, mode).fault;
  EXPECT_THAT(fault, HasSubstr("968 x 360"));
  EXPECT_THAT(fault, HasSubstr("640 x 360"));
  EXPECT_THAT(open_v4l2("/dev/null", mode).fault, HasSubstr("is no camera"));
  EXPECT_THAT(open_v4l2("/dev/video99", mode).fault, HasSubstr("No such file"));
}

}  // namespace
}  // namespace nadir::capture
