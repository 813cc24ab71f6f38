// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Live sources: what needs no camera, and against the kernel's virtual ones (`./dev guest`).
#include "nadir/capture/camera_source.hpp"

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <span>
#include <thread>

#include "fake_libcamera_plugin.hpp"
#include "nadir/core/check.hpp"
#include "nadir/pipeline/progress.hpp"
#include "vivid.hpp"

namespace nadir::capture {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using testing::HasSubstr;

std::string matrix(const std::string& name, int rows, int columns, const std::string& values) {
  return name + ": !!opencv-matrix\n  rows: " + std::to_string(rows) +
         "\n  cols: " + std::to_string(columns) + "\n  dt: d\n  data: [" + values + "]\n";
}

const std::string kCamera =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 360\n" +
    matrix("camera_matrix", 3, 3, "500., 0., 319.5, 0., 500., 179.5, 0., 0., 1.") +
    matrix("distortion_coefficients", 1, 5, "0., 0., 0., 0., 0.");
const std::string kRight =
    matrix("camera_matrix_right", 3, 3, "500., 0., 319.5, 0., 500., 179.5, 0., 0., 1.") +
    matrix("distortion_coefficients_right", 1, 5, "0., 0., 0., 0., 0.") +
    matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") + matrix("T", 3, 1, "-0.1, 0., 0.");

class CameraSourceTest : public testing::Test {
 protected:
  CameraSourceTest() {
    std::string name = testing::TempDir() + "nadir-camera-XXXXXX";
    folder = mkdtemp(name.data());
    config.calibration = folder / "camera.yml";
    calibrate(kCamera);
  }
  ~CameraSourceTest() override { std::filesystem::remove_all(folder); }

  void calibrate(const std::string& text) const { std::ofstream(config.calibration) << text; }

  std::string refusal() const {
    try {
      const CameraSource source(config);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder;
  Config config;
  std::stop_source stop;
};

TEST_F(CameraSourceTest, RefusesSettingsThatCannotBeRight) {
  config.camera_right = "B";
  EXPECT_THAT(refusal(), HasSubstr("tell the two cameras of a pair apart"));
  config.camera = "libcamera:auto";
  EXPECT_THAT(refusal(), HasSubstr("tell the two cameras of a pair apart"));
  config.camera = "A";
  EXPECT_THAT(refusal(), HasSubstr("calibrate the pair"));
  calibrate(kCamera + kRight);
  EXPECT_EQ(refusal(), "");
  config.camera = "/dev/video0";
  EXPECT_THAT(refusal(), HasSubstr("/dev/v4l/by-path"));
  config.camera_right = "";
  EXPECT_EQ(refusal(), "");
  config.calibration = folder / "none.yml";
  EXPECT_THAT(refusal(), HasSubstr("none.yml"));
}

TEST_F(CameraSourceTest, WaitsForACameraAndStopsAtOnce) {
  config.camera = "/dev/no-such-camera";
  CameraSource source(config);
  const auto begin = Clock::now();
  const auto first = source.next(stop.get_token());
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->shot);
  ASSERT_EQ(first->alerts.size(), 1u);
  EXPECT_EQ(first->alerts[0].kind, AlertKind::camera_lost);
  EXPECT_LT(Clock::now() - begin, 500ms);
  const auto second = source.next(stop.get_token());  // nothing new within a second
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->alerts.empty());
  EXPECT_GT(Clock::now() - begin, 800ms);
  std::jthread ending([&] { stop.request_stop(); });
  EXPECT_FALSE(source.next(stop.get_token()));
}

/// A pair without a driver, of libcamera's fake plugin.
class FakePairTest : public CameraSourceTest {
 protected:
  FakePairTest() : grey(360 * (640 + FakePlugin::kPadding), 105) {
    const auto plugins =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "fake_plugins" / "abi2";
    ::setenv("NADIR_PLUGINS", plugins.c_str(), 1);
    void* const library = ::dlopen((plugins / "nadir-libcamera-fake.so").c_str(), RTLD_NOW);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as dlsym(3) has it
    const auto entry = reinterpret_cast<decltype(&fake_plugin)>(::dlsym(library, "fake_plugin"));
    fakes = {static_cast<FakePlugin*>(entry()), 2};
    for (FakePlugin& fake : fakes) fake = {};
    calibrate(kCamera + kRight);
    config.camera = "libcamera:left";
    config.camera_right = "libcamera:right";
    config.rate_hz = 0;
  }
  ~FakePairTest() override { ::unsetenv("NADIR_PLUGINS"); }

  /// The next pair; none within some seconds.
  std::optional<Shot> next_shot(CameraSource& source) {
    for (const auto end = Clock::now() + 5s; Clock::now() < end;) {
      std::this_thread::sleep_for(10ms);  // no camera's are closer
      for (FakePlugin& fake : fakes) {
        fake.picture = {monotonic_now(), 0, nullptr, grey.data(), grey.size(), nullptr};
        fake.next = NADIR_TAKEN_PICTURE;
      }
      auto captured = source.next(stop.get_token());
      if (captured->shot) return captured->shot;
    }
    return std::nullopt;
  }

  const std::vector<std::uint8_t> grey;  ///< as bright as it should be
  std::span<FakePlugin> fakes;
};

TEST_F(FakePairTest, IsExposedAlikeFromTheStartAndWhenOneIsBack) {
  fakes[0].exposing = {1, 4, 0.1, 40, 1, 16, 8, 1.5};
  fakes[1].exposing = {1, 4, 0.1, 40, 1, 16, 20, 4};
  const auto expect_alike = [&] {
    for (FakePlugin& fake : fakes) {
      EXPECT_EQ(fake.ms, 8);
      EXPECT_EQ(fake.gain, 1.5);
      fake.ms = fake.gain = 0;
    }
  };
  CameraSource source(config);
  ASSERT_TRUE(next_shot(source));
  expect_alike();
  ASSERT_TRUE(next_shot(source));
  EXPECT_EQ(fakes[1].ms, 0);  // it stays as it was set
  for (FakePlugin& fake : fakes) {
    fake.next = NADIR_TAKEN_GONE;
    while (source.next(stop.get_token())->alerts.empty()) continue;
    EXPECT_FALSE(fake.open);
    ASSERT_TRUE(next_shot(source));
    EXPECT_TRUE(fake.open);
    expect_alike();
  }
}

TEST_F(FakePairTest, TellsTheWatchOfEachCameraThatWasSlowToOpen) {
  static pipeline::Progress progress;
  static std::chrono::nanoseconds busy{};
  pipeline::Progress::of_this_thread() = &progress;
  fakes[0].opening = [] { std::this_thread::sleep_for(1s); };
  fakes[1].opening = [] { busy = progress.busy(pipeline::Progress::Clock::now()).value(); };
  progress.begin();
  CameraSource source(config);
  EXPECT_TRUE(source.next(stop.get_token()));
  pipeline::Progress::of_this_thread() = nullptr;
  EXPECT_GT(busy, 0ns);
  EXPECT_LT(busy, 500ms);
}

/// With a camera there.
class LiveSourceTest : public CameraSourceTest {
 protected:
  void SetUp() override {
    nodes = vivid_nodes();
    if (nodes.size() < 2) GTEST_SKIP() << "not run: no virtual cameras (modprobe vivid n_devs=2)";
    config.camera = nodes[0];
  }

  /// Alerts on the way are kept.
  std::optional<Shot> next_shot(CameraSource& source) {
    for (const auto end = Clock::now() + 10s; Clock::now() < end;) {
      auto captured = source.next(stop.get_token());
      for (const Alert& alert : captured->alerts) alerts.push_back(alert);
      if (captured->shot) return captured->shot;
    }
    return std::nullopt;
  }

  std::vector<std::string> nodes;
  std::vector<Alert> alerts;
};

TEST_F(LiveSourceTest, GivesImagesAtTheRateAskedFor) {
  config.rate_hz = 4;
  CameraSource source(config);
  Time before = 0;
  for (std::uint64_t i = 0; i < 6; ++i) {
    const auto shot = next_shot(source);
    ASSERT_TRUE(shot);
    EXPECT_EQ(shot->image, i + (shot->missed_before > 0));
    ASSERT_TRUE(shot->frame);
    EXPECT_EQ(shot->frame->colour.size(), cv::Size(640, 360));
    EXPECT_EQ(shot->frame->grey.size(), cv::Size(640, 360));
    EXPECT_TRUE(shot->frame->right.empty());
    if (i > 0 && shot->missed_before == 0) {
      EXPECT_NEAR(seconds(shot->time - before), 0.25, 0.06);
    }
    before = shot->time;
  }
}

TEST_F(LiveSourceTest, PairsTwoCameras) {
  calibrate(kCamera + kRight);
  // By their buses, since video0 may be another after the next start.
  config.camera = "platform:vivid-000";
  config.camera_right = "platform:vivid-001";
  CameraSource source(config);
  for (int i = 0; i < 25; ++i) {
    const auto shot = next_shot(source);
    ASSERT_TRUE(shot);
    EXPECT_EQ(shot->frame->right.size(), cv::Size(640, 360));
  }
}

TEST_F(LiveSourceTest, TellsOfAnUnpluggedCameraAndGoesOnWhenItIsBack) {
  CameraSource source(config);
  ASSERT_TRUE(next_shot(source));
  unplug_vivid();
  const auto unplugged = Clock::now();
  while (alerts.empty() && Clock::now() < unplugged + 5s) {
    const auto captured = source.next(stop.get_token());
    alerts.insert(alerts.end(), captured->alerts.begin(), captured->alerts.end());
  }
  EXPECT_LT(Clock::now() - unplugged, 1s);
  ASSERT_FALSE(alerts.empty());
  EXPECT_EQ(alerts[0].kind, AlertKind::camera_lost);
  std::this_thread::sleep_for(1500ms);
  plug_vivid();
  const auto plugged = Clock::now();
  ASSERT_TRUE(next_shot(source));
  EXPECT_LT(Clock::now() - plugged, 3s);
  EXPECT_EQ(alerts.back().kind, AlertKind::camera_back);
}

TEST_F(LiveSourceTest, CountsAndTellsTheImagesTheDriverLost) {
  config.rate_hz = 0;
  CameraSource source(config);
  ASSERT_TRUE(next_shot(source));
  set_vivid(nodes[0], "Percentage of Dropped Buffers", 50);
  std::uint64_t missed = 0, shots = 0, images = 0;
  bool told = false;
  for (; shots < 40; ++shots) {
    const auto shot = next_shot(source);
    ASSERT_TRUE(shot);
    missed += shot->missed_before;
    images = shot->image;
    for (const Alert& alert : shot->alerts) told = told || alert.kind == AlertKind::images_dropped;
  }
  set_vivid(nodes[0], "Percentage of Dropped Buffers", 0);
  EXPECT_GT(missed, 5u);
  EXPECT_EQ(images, shots + missed);  // each image has its number, taken or missed
  EXPECT_TRUE(told);
}

}  // namespace
}  // namespace nadir::capture
