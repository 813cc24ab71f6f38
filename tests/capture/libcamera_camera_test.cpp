// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The plugin as it was built, and libcamera with the kernel's virtual camera; `./dev guest` runs it
// where that is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <thread>

#include "libcamera_camera.hpp"
#include "nadir/capture/camera_source.hpp"

namespace nadir::capture {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
namespace fs = std::filesystem;

const fs::path kPlugins = fs::read_symlink("/proc/self/exe").parent_path() / "plugins";
constexpr const char* kDriver = "/sys/bus/platform/drivers/vimc";

std::ptrdiff_t open_files() {
  const fs::directory_iterator files("/proc/self/fd");
  return std::distance(begin(files), end(files));
}

constexpr const char* kCalibration = R"(%YAML:1.0
---
image_width: 480
image_height: 360
camera_matrix: !!opencv-matrix
  rows: 3
  cols: 3
  dt: d
  data: [400., 0., 239.5, 0., 400., 179.5, 0., 0., 1.]
distortion_coefficients: !!opencv-matrix
  rows: 1
  cols: 5
  dt: d
  data: [0., 0., 0., 0., 0.]
)";

class LibcameraCameraTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kPlugins)) GTEST_SKIP() << "not run: no libcamera when this was built";
    if (!fs::exists(kDriver)) GTEST_SKIP() << "not run: no virtual camera (modprobe vimc)";
    camera = open();
  }

  std::unique_ptr<Camera> open(const std::string& id = "auto") const {
    OpenedCamera opened = open_libcamera(id, mode, kPlugins);
    EXPECT_EQ(opened.fault, "");
    return std::move(opened.camera);
  }
  std::string fault_of(const std::string& id) const {
    return open_libcamera(id, mode, kPlugins).fault;
  }

  /// Waits for it, some seconds at most.
  Camera::Taken next(int patience_ms = 5000) const {
    pollfd waiting{camera->descriptor(), POLLIN | POLLPRI, 0};
    ::poll(&waiting, 1, patience_ms);
    return camera->take();
  }

  CameraMode mode{480, 360};
  std::unique_ptr<Camera> camera;
};

TEST(LibcameraPlugin, IsLoadedWithTheLibcameraItWasBuiltFor) {
  if (!fs::exists(kPlugins)) GTEST_SKIP() << "not run: no libcamera when this was built";
  const std::string fault = open_libcamera("no such camera", {480, 360}, kPlugins).fault;
  EXPECT_THAT(fault, StartsWith("libcamera:no such camera: "));
  EXPECT_THAT(fault, testing::Not(HasSubstr("plugin")));
}

TEST_F(LibcameraCameraTest, GivesPicturesThatCanBeDecoded) {
  ASSERT_TRUE(camera);
  Camera::Taken taken = next();
  ASSERT_TRUE(taken.picture) << taken.gone;
  const Picture& picture = *taken.picture;
  EXPECT_EQ(picture.fault, "");
  ASSERT_TRUE(picture.encoding.raw);
  const auto decoded = image_io::decode_raw({*picture.encoding.raw, picture.encoding.order, 480,
                                             360, picture.encoding.stride, picture.bytes},
                                            1, image_io::Colour::bgr);
  ASSERT_EQ(decoded.fault, "");
  // Its bars are white, yellow, cyan and so on, from the left; above there is writing.
  const cv::Vec3b white = decoded.image.at<cv::Vec3b>(330, 30);
  const cv::Vec3b yellow = decoded.image.at<cv::Vec3b>(330, 90);
  EXPECT_GT(white[0], 150);
  EXPECT_LT(yellow[0], 100);
  EXPECT_GT(yellow[1], 150);
  EXPECT_GT(yellow[2], 150);
}

TEST_F(LibcameraCameraTest, StampsPicturesByTheMonotonicClock) {
  ASSERT_TRUE(camera);
  Time before = 0;
  for (int i = 0; i < 15; ++i) {  // more than there are buffers
    const Camera::Taken taken = next();
    ASSERT_TRUE(taken.picture) << i << taken.gone;
    EXPECT_GT(taken.picture->time, before);
    EXPECT_LT(taken.picture->time, monotonic_now());
    EXPECT_GT(taken.picture->time, monotonic_now() - from_seconds(5));
    before = taken.picture->time;
  }
}

TEST_F(LibcameraCameraTest, KeepsAPictureWhileItGivesOthersAndWhenItHasEnded) {
  ASSERT_TRUE(camera);
  Camera::Taken kept = next();
  ASSERT_TRUE(kept.picture);
  const std::vector<std::uint8_t> bytes(kept.picture->bytes.begin(), kept.picture->bytes.end());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(next().picture) << i;
  camera.reset();
  EXPECT_TRUE(std::ranges::equal(kept.picture->bytes, bytes));
  camera = open();
  EXPECT_TRUE(next().picture);
  kept = {};
  EXPECT_TRUE(next().picture);
}

TEST_F(LibcameraCameraTest, CanBeOpenedAgainAndAgain) {
  const std::ptrdiff_t files = open_files();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(camera) << i;
    if (i % 2 == 0) {
      ASSERT_TRUE(next().picture) << i;
    }
    camera.reset();
    camera = open();
  }
  EXPECT_EQ(open_files(), files);
}

TEST_F(LibcameraCameraTest, IsASource) {
  camera.reset();
  ::setenv("NADIR_PLUGINS", kPlugins.c_str(), 1);
  Config config;
  config.camera = "libcamera:auto";
  config.calibration = testing::TempDir() + "nadir-vimc.yml";
  std::ofstream(config.calibration) << kCalibration;
  CameraSource source(config);
  const std::stop_source stop;
  for (int i = 0; i < 8; ++i) {
    const auto captured = source.next(stop.get_token());
    ASSERT_TRUE(captured && captured->shot) << i;
    EXPECT_TRUE(captured->alerts.empty()) << captured->alerts.front().message;
    EXPECT_EQ(captured->shot->frame->colour.size(), cv::Size(480, 360));
    EXPECT_EQ(captured->shot->image, static_cast<std::uint64_t>(i));
  }
  ::unsetenv("NADIR_PLUGINS");
  fs::remove(config.calibration);
}

TEST_F(LibcameraCameraTest, FindsItByItsIdOrTheEndOfIt) {
  camera.reset();
  const std::string fault = fault_of("no such camera");
  EXPECT_THAT(fault, HasSubstr("no camera of libcamera is so called, but "));
  const std::string id = fault.substr(fault.rfind("but ") + 4);
  for (const std::string& name : {id, id.substr(id.size() - 3)}) {
    camera = open(name);
    EXPECT_TRUE(camera) << name;
    camera.reset();
  }
}

TEST_F(LibcameraCameraTest, LeavesACameraToTheOneThatHasIt) {
  ASSERT_TRUE(camera);
  EXPECT_THAT(fault_of("auto"), HasSubstr("in use by another program"));
  EXPECT_TRUE(next().picture);
}

TEST_F(LibcameraCameraTest, NamesTheSizesThereAreAndWhatItCannotBeSetTo) {
  camera.reset();
  mode.width = 5;
  EXPECT_THAT(fault_of("auto"),
              testing::ContainsRegex("does not offer 5 x 360 px.*, but [0-9]+x[0-9]+"));
  mode = {480, 360, 10, 5, 2, 1};
  const OpenedCamera opened = open_libcamera("auto", mode, kPlugins);
  ASSERT_TRUE(opened.camera) << opened.fault;
  EXPECT_THAT(opened.remarks, testing::Contains(HasSubstr("its exposure cannot be set to 5")));
  EXPECT_THAT(opened.remarks, testing::Contains(HasSubstr("its focus cannot be set to 1")));
}

TEST_F(LibcameraCameraTest, ExposesByItselfWithoutTheControls) {
  ASSERT_TRUE(camera);
  EXPECT_FALSE(camera->exposing());
  camera->expose({5, 1});
  EXPECT_TRUE(next().picture);
}

TEST_F(LibcameraCameraTest, OutlivesADriverThatGoesAndIsBackWithIt) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(camera);
    ASSERT_TRUE(next().picture);
    std::ofstream(fs::path(kDriver) / "unbind") << "vimc.0" << std::flush;
    while (next(500).picture) continue;  // those that were there already
    const Time begin = monotonic_now();
    camera.reset();
    EXPECT_LT(monotonic_now() - begin, from_seconds(3));
    EXPECT_THAT(fault_of("auto"), HasSubstr("libcamera has no camera"));
    std::ofstream(fs::path(kDriver) / "bind") << "vimc.0" << std::flush;
    for (int k = 0; k < 50 && !fault_of("auto").empty(); ++k) std::this_thread::sleep_for(100ms);
    camera = open();
  }
  ASSERT_TRUE(camera);
  EXPECT_TRUE(next().picture);
}

}  // namespace
}  // namespace nadir::capture
