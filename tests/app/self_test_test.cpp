// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "self_test.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

class SelfTest : public testing::Test {
 protected:
  SelfTest() {
    std::string name = testing::TempDir() + "nadir-self-test-XXXXXX";
    folder = mkdtemp(name.data());
  }
  ~SelfTest() override { fs::remove_all(folder); }

  void write(const fs::path& file, const std::string& text) const {
    fs::create_directories((folder / file).parent_path());
    std::ofstream(folder / file) << text;
  }

  fs::path folder;
};

TEST_F(SelfTest, NamesTheSensorThatIsSilent) {
  sensors::Config config;
  EXPECT_EQ(check_sensors(config, 1s)[0].verdict, Verdict::absent);
  config.inputs = "nmea:serial:/dev/no-such-line:4800";
  const auto findings = check_sensors(config, 1s);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::doubtful);
  EXPECT_THAT(findings[0].item, HasSubstr("/dev/no-such-line"));
  EXPECT_THAT(findings[0].found, HasSubstr("No such file"));
}

TEST_F(SelfTest, CallsMissingCamerasAndCalibrationsBad) {
  Config config;
  config.capture.calibration = folder / "camera.yml";
  EXPECT_EQ(check_cameras(config, 1s)[0].verdict, Verdict::bad);
  write("camera.yml",
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 360\n"
        "camera_matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
        "  data: [500., 0., 319.5, 0., 500., 179.5, 0., 0., 1.]\n"
        "distortion_coefficients: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
        "  data: [0., 0., 0., 0., 0.]\n");
  config.capture.camera = "/dev/no-such-camera";
  const auto findings = check_cameras(config, 1s);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].verdict, Verdict::good);
  EXPECT_EQ(findings[1].verdict, Verdict::bad);
  EXPECT_THAT(findings[1].found, HasSubstr("/dev/no-such-camera"));
}

TEST_F(SelfTest, FindsThePageWhereItIsServed) {
  serve::Config config;
  config.port = 0;
  constexpr std::array<std::uint8_t, 2> kPage{0x1f, 0x8b};
  auto server = std::make_unique<serve::WebServer>(
      config, std::vector<serve::Asset>{{"/index.html", "text/html", kPage}});
  config.port = server->port();
  EXPECT_EQ(check_page(config).verdict, Verdict::good);
  server.reset();
  EXPECT_EQ(check_page(config).verdict, Verdict::absent);
}

}  // namespace
}  // namespace nadir::app
