// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "v4l2_devices.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <thread>

#include "ioctl.hpp"
#include "nadir/pipeline/progress.hpp"
#include "support/failing_folder.hpp"

namespace nadir::capture {
namespace {

using testing::HasSubstr;

const V4l2Device kLeft{"/dev/video0", "uvcvideo", "Stellar", "usb-0000:01:00.0-1.1", "A17"};
const V4l2Device kRight{"/dev/video2", "uvcvideo", "Stellar", "usb-0000:01:00.0-1.2", "B03"};
const V4l2Device kDecoder{"/dev/video10", "bcm2835-codec", "decoder", "platform:codec", ""};

TEST(FindV4l2, TakesAPathAsItIs) {
  EXPECT_EQ(find_v4l2("/dev/v4l/by-path/x", {}).node, "/dev/v4l/by-path/x");
}

TEST(FindV4l2, FindsADeviceByWhatDoesNotChangeWithTheOrderOfPlugging) {
  for (const auto& devices : {std::vector{kLeft, kRight}, std::vector{kRight, kLeft}}) {
    EXPECT_EQ(find_v4l2("B03", devices).node, "/dev/video2");
    EXPECT_EQ(find_v4l2("usb-0000:01:00.0-1.1", devices).node, "/dev/video0");
  }
  EXPECT_EQ(find_v4l2("Stellar", {kLeft, kDecoder}).node, "/dev/video0");
}

TEST(FindV4l2, TakesTheOnlyUsbCameraByItself) {
  EXPECT_EQ(find_v4l2("auto", {kDecoder, kLeft}).node, "/dev/video0");
}

TEST(FindV4l2, NamesTheCamerasThereAreWhereItCannotChoose) {
  const FoundDevice two = find_v4l2("auto", {kLeft, kRight});
  EXPECT_EQ(two.node, "");
  EXPECT_THAT(two.fault, HasSubstr("serial A17"));
  EXPECT_THAT(two.fault, HasSubstr("serial B03"));
  EXPECT_THAT(find_v4l2("Stellar", {kLeft, kRight}).fault, HasSubstr("more than one"));
  EXPECT_THAT(find_v4l2("C99", {kLeft}).fault, HasSubstr("there is no camera 'C99'"));
  EXPECT_THAT(find_v4l2("auto", {}).fault, HasSubstr("no camera is there"));
  EXPECT_EQ(find_v4l2("", {kDecoder}).node, "");  // as the serial number of many
}

TEST(V4l2Devices, AreLookedForAsFarAsDevCanBeRead) {
  const support::FailingFolder failing("/dev");
  EXPECT_NO_THROW(v4l2_devices());
}

TEST(V4l2Control, TellsTheWatchThatACallHasComeBack) {
  using namespace std::chrono_literals;
  using pipeline::Progress;
  Progress progress;
  Progress::of_this_thread() = &progress;
  progress.begin();
  std::this_thread::sleep_for(500ms);
  int bytes = 0;
  EXPECT_EQ(control(-1, FIONREAD, bytes), -1);
  EXPECT_EQ(errno, EBADF);
  Progress::of_this_thread() = nullptr;
  EXPECT_LT(progress.busy(Progress::Clock::now()).value(), 400ms);
}

}  // namespace
}  // namespace nadir::capture
