// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The program's side of the plugin, against plugins without libcamera.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

#include "fake_libcamera_plugin.hpp"
#include "libcamera_camera.hpp"
#include "plugin/losses.hpp"
#include "plugin/steering.hpp"
#include "support/failing_folder.hpp"

namespace nadir::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

const fs::path kFakes = fs::read_symlink("/proc/self/exe").parent_path() / "fake_plugins";

class LibcameraPluginTest : public testing::Test {
 protected:
  LibcameraPluginTest() {
    std::string name = testing::TempDir() + "nadir-plugins-XXXXXX";
    empty = mkdtemp(name.data());
    void* const library = ::dlopen((kFakes / "abi2" / "nadir-libcamera-fake.so").c_str(), RTLD_NOW);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as dlsym(3) has it
    const auto entry = reinterpret_cast<decltype(&fake_plugin)>(::dlsym(library, "fake_plugin"));
    fake = static_cast<FakePlugin*>(entry());
    *fake = {};
  }
  ~LibcameraPluginTest() override { fs::remove_all(empty); }

  OpenedCamera open(const std::string& id = "auto") const {
    return open_libcamera(id, mode, kFakes / "abi2");
  }

  CameraMode mode{6, 2, 10, 5, 1.5, 2.25};
  fs::path empty;
  FakePlugin* fake = nullptr;
};

TEST_F(LibcameraPluginTest, NamesThePackageWhenThereIsNoPlugin) {
  for (const fs::path& folder : {empty, empty / "none"}) {
    const OpenedCamera opened = open_libcamera("auto", mode, folder);
    EXPECT_FALSE(opened.camera);
    EXPECT_THAT(opened.fault, HasSubstr("libcamera:auto: there is no plugin"));
    EXPECT_THAT(opened.fault, HasSubstr(folder.string()));
    EXPECT_THAT(opened.fault, HasSubstr("install the package nadir-libcamera"));
  }
}

TEST_F(LibcameraPluginTest, SaysWhyNoneCanBeLoaded) {
  std::ofstream(empty / "nadir-libcamera-0.1.so") << "no library";
  const OpenedCamera opened = open_libcamera("auto", mode, empty);
  EXPECT_FALSE(opened.camera);
  EXPECT_THAT(opened.fault, HasSubstr("nadir-libcamera-0.1.so: file too short"));
  EXPECT_THAT(opened.fault, HasSubstr("install the package nadir-libcamera"));
}

TEST_F(LibcameraPluginTest, UsesNoPluginOfAnotherVersion) {
  const OpenedCamera opened = open_libcamera("auto", mode, kFakes / "abi1");
  EXPECT_FALSE(opened.camera);
  EXPECT_THAT(opened.fault, HasSubstr("nadir-libcamera-fake.so: is of another version of nadir"));
}

TEST_F(LibcameraPluginTest, UsesTheNewestThatCanBeLoaded) {
  fs::copy_file(kFakes / "abi2" / "nadir-libcamera-fake.so", empty / "nadir-libcamera-0.9.so");
  std::ofstream(empty / "nadir-libcamera-0.10.so") << "of a libcamera that is not here";
  std::ofstream(empty / "other.so") << "no plugin";
  EXPECT_EQ(open_libcamera("auto", mode, empty).fault, "");
  const support::FailingFolder failing(empty);
  EXPECT_NO_THROW(open_libcamera("auto", mode, empty));
}

TEST_F(LibcameraPluginTest, IsLookedForWhereTheEnvironmentSays) {
  ::setenv("NADIR_PLUGINS", empty.c_str(), 1);
  EXPECT_THAT(open_camera("libcamera:auto", mode).fault, HasSubstr(empty.string()));
  ::setenv("NADIR_PLUGINS", (kFakes / "abi2").c_str(), 1);
  EXPECT_EQ(open_camera("libcamera:auto", mode).fault, "");
  ::unsetenv("NADIR_PLUGINS");
  EXPECT_THAT(open_camera("/dev/no-such-camera", mode).fault, HasSubstr("No such file"));
}

TEST_F(LibcameraPluginTest, AsksForTheModeAndTellsWhatIsRefused) {
  const OpenedCamera opened = open("imx477@1a");
  ASSERT_TRUE(opened.camera);
  EXPECT_THAT(opened.remarks, ElementsAre("libcamera:imx477@1a: its gain cannot be set",
                                          "libcamera:imx477@1a: its focus cannot be set"));
  EXPECT_EQ(opened.camera->descriptor(), fake->descriptor);
  EXPECT_EQ(opened.camera->rate_hz(), 10);
  EXPECT_EQ(fake->wanted.width, 6);
  EXPECT_EQ(fake->wanted.height, 2);
  EXPECT_EQ(fake->wanted.exposure_ms, 5);
  EXPECT_EQ(fake->wanted.gain, 1.5);
  EXPECT_EQ(fake->wanted.focus, 2.25);
  EXPECT_GT(fake->wanted.format_count, 10u);
  const OpenedCamera none = open("none");
  EXPECT_FALSE(none.camera);
  EXPECT_EQ(none.fault, "libcamera:none: libcamera has no camera");
}

TEST_F(LibcameraPluginTest, GivesPicturesAndTheirBuffersBack) {
  OpenedCamera opened = open();
  ASSERT_TRUE(opened.camera);
  EXPECT_FALSE(opened.camera->take().picture);
  const std::vector<std::uint8_t> bytes(2 * (6 + FakePlugin::kPadding), 7);
  int buffer = 0;
  fake->picture = {123, 4, nullptr, bytes.data(), bytes.size(), &buffer};
  fake->next = NADIR_TAKEN_PICTURE;
  Camera::Taken taken = opened.camera->take();
  ASSERT_TRUE(taken.picture);
  const Picture& picture = *taken.picture;
  EXPECT_EQ(picture.time, 123);
  EXPECT_EQ(picture.lost_before, 4u);
  EXPECT_EQ(picture.fault, "");
  EXPECT_EQ(picture.encoding.raw, image_io::RawFormat::grey);
  EXPECT_EQ(picture.encoding.stride, 6 + FakePlugin::kPadding);
  EXPECT_EQ(picture.bytes.data(), bytes.data());
  EXPECT_EQ(picture.bytes.size(), bytes.size());
  EXPECT_EQ(fake->out, 1);
  taken = {};
  EXPECT_EQ(fake->out, 0);
  EXPECT_EQ(fake->given_back, &buffer);
}

TEST_F(LibcameraPluginTest, GivesDamagedPicturesBackToo) {
  OpenedCamera opened = open();
  int buffer = 0;
  fake->picture = {123, 0, "libcamera calls it damaged", nullptr, 0, &buffer};
  fake->next = NADIR_TAKEN_PICTURE;
  Camera::Taken taken = opened.camera->take();
  ASSERT_TRUE(taken.picture);
  EXPECT_EQ(taken.picture->fault, "libcamera calls it damaged");
  EXPECT_TRUE(taken.picture->bytes.empty());
  taken = {};
  EXPECT_EQ(fake->given_back, &buffer);
}

TEST_F(LibcameraPluginTest, KeepsPicturesThatOutliveTheCamera) {
  OpenedCamera opened = open();
  const std::uint8_t byte = 0;
  fake->picture = {1, 0, nullptr, &byte, 1, nullptr};
  fake->next = NADIR_TAKEN_PICTURE;
  Camera::Taken taken = opened.camera->take();
  opened.camera.reset();
  EXPECT_TRUE(fake->stopped);
  EXPECT_TRUE(fake->open);
  taken = {};
  EXPECT_EQ(fake->out, 0);
  EXPECT_FALSE(fake->open);
}

TEST_F(LibcameraPluginTest, SteersACameraThatCanBe) {
  fake->exposing = {1, 9, 0.1, 40, 1, 16, 8, 1.5};
  const OpenedCamera opened = open();
  ASSERT_TRUE(opened.camera);
  const auto exposing = opened.camera->exposing();
  ASSERT_TRUE(exposing);
  EXPECT_EQ(exposing->range.shortest_ms, 0.1);
  EXPECT_EQ(exposing->range.longest_ms, 40);
  EXPECT_EQ(exposing->range.least_gain, 1);
  EXPECT_EQ(exposing->range.most_gain, 16);
  EXPECT_EQ(exposing->range.delay, 9);
  EXPECT_EQ(exposing->now, (Exposure{8, 1.5}));
  opened.camera->expose({12, 2});
  EXPECT_EQ(fake->ms, 12);
  EXPECT_EQ(fake->gain, 2);
}

TEST_F(LibcameraPluginTest, LeavesACameraThatExposesByItselfAlone) {
  const OpenedCamera opened = open();
  ASSERT_TRUE(opened.camera);
  EXPECT_FALSE(opened.camera->exposing());
  opened.camera->expose({12, 2});
  EXPECT_EQ(fake->ms, 0);
}

TEST_F(LibcameraPluginTest, SaysWhyTheCameraHasEnded) {
  const OpenedCamera opened = open();
  fake->next = NADIR_TAKEN_GONE;
  EXPECT_EQ(opened.camera->take().gone, "is not there any more");
}

constexpr Bounds kExposure_us{0, 1e9}, kGain{1, 16};  // as Raspberry Pi's have it

NadirCameraWanted wanting(double exposure_ms, double gain) {
  NadirCameraWanted wanted{};
  wanted.exposure_ms = exposure_ms;
  wanted.gain = gain;
  return wanted;
}

TEST(LibcameraSteering, KeepsTheExposureWithinTheFrame) {
  const NadirCameraWanted wanted = wanting(0, -1);
  const NadirExposing found = steering(kExposure_us, kGain, 100'000, wanted);
  EXPECT_EQ(found.steered, 1);
  EXPECT_GT(found.shortest_ms, 0);
  EXPECT_LT(found.shortest_ms, 0.1);
  EXPECT_DOUBLE_EQ(found.longest_ms, 100);
  EXPECT_EQ(found.least_gain, 1);
  EXPECT_EQ(found.most_gain, 16);
  EXPECT_DOUBLE_EQ(steering({75, 30'000}, kGain, 100'000, wanted).longest_ms, 30);
  EXPECT_DOUBLE_EQ(steering({75, 30'000}, kGain, 0, wanted).longest_ms, 30);
  EXPECT_LE(steering(kExposure_us, kGain, 0, wanted).longest_ms, 100);
}

TEST(LibcameraSteering, BeginsShortAndWithoutNoise) {
  const NadirCameraWanted wanted = wanting(0, -1);
  EXPECT_DOUBLE_EQ(steering(kExposure_us, kGain, 100'000, wanted).ms, 8);
  EXPECT_DOUBLE_EQ(steering(kExposure_us, kGain, 10'000, wanted).ms, 5);
  EXPECT_DOUBLE_EQ(steering({9000, 1e9}, kGain, 10'000, wanted).ms, 9);
  EXPECT_EQ(steering(kExposure_us, kGain, 10'000, wanted).gain, 1);
  EXPECT_EQ(steering(kExposure_us, {0, 16}, 10'000, wanted).gain, 1);  // 0: by itself
}

TEST(LibcameraSteering, LeavesWhatIsFixed) {
  EXPECT_EQ(steering(kExposure_us, kGain, 100'000, wanting(5, -1)).steered, 0);
  EXPECT_EQ(steering(kExposure_us, kGain, 100'000, wanting(5, 2)).steered, 0);
  for (const auto& [wanted, gain] : {std::pair{2.5, 2.5}, {20, 16}}) {
    const NadirExposing found = steering(kExposure_us, kGain, 100'000, wanting(0, wanted));
    EXPECT_EQ(found.steered, 1);
    EXPECT_EQ(found.least_gain, gain);
    EXPECT_EQ(found.most_gain, gain);
    EXPECT_EQ(found.gain, gain);
  }
}

TEST(LibcameraSteering, NeedsTheBoundsOfBoth) {
  const NadirCameraWanted wanted = wanting(0, -1);
  const double none = std::nan("");
  EXPECT_EQ(steering({none, none}, kGain, 100'000, wanted).steered, 0);
  EXPECT_EQ(steering({0, none}, kGain, 100'000, wanted).steered, 0);
  EXPECT_EQ(steering(kExposure_us, {none, none}, 100'000, wanted).steered, 0);
  EXPECT_EQ(steering(kExposure_us, {1, none}, 100'000, wanted).steered, 0);
  EXPECT_EQ(steering({0, 0}, kGain, 100'000, wanted).steered, 0);
}

TEST(LibcameraLosses, AreCountedByTheDriversNumber) {
  Losses losses;
  EXPECT_EQ(losses.before(7, 0, 0), 0u);
  EXPECT_EQ(losses.before(8, 900, 0), 0u);
  EXPECT_EQ(losses.before(11, 1000, 0), 2u);
  EXPECT_EQ(losses.before(11, 1100, 0), 0u);
  EXPECT_EQ(losses.before(3, 1200, 0), 0u);
  EXPECT_EQ(losses.before(UINT32_MAX, 1300, 0), 0u);
  EXPECT_EQ(losses.before(1, 1400, 0), 1u);
}

TEST(LibcameraLosses, AreCountedByTheTimeWhereTheNumberHidesThem) {
  Losses losses;
  EXPECT_EQ(losses.before(1, 0, 100), 0u);
  EXPECT_EQ(losses.before(2, 104, 100), 0u);
  EXPECT_EQ(losses.before(3, 398, 100), 2u);
  EXPECT_EQ(losses.before(4, 490, 33), 0u);  // it has become faster since
  EXPECT_EQ(losses.before(5, 523, 33), 0u);
  EXPECT_EQ(losses.before(7, 556, 33), 1u);
  EXPECT_EQ(losses.before(8, 500, 33), 0u);
}

TEST(LibcameraLosses, AreNotCountedByATimeThatIsWrong) {
  constexpr std::int64_t kFrame = 100'000'000, kBegin = 1'000'000 * kFrame;
  for (const std::int64_t wrong : {INT64_MAX / 2, kBegin + 36'000 * kFrame, std::int64_t{0}}) {
    Losses losses;
    EXPECT_EQ(losses.before(1, kBegin, kFrame), 0u);
    EXPECT_EQ(losses.before(2, wrong, kFrame), 0u);
    EXPECT_EQ(losses.before(3, kBegin + 2 * kFrame, kFrame), 0u);
    EXPECT_EQ(losses.before(5, kBegin + 4 * kFrame, kFrame), 1u);
  }
}

}  // namespace
}  // namespace nadir::capture
