// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/iio.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>

namespace nadir::sensors {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;
constexpr Time kSecond = 1'000'000'000;

class IioTest : public testing::Test {
 protected:
  IioTest() {
    std::string name = testing::TempDir() + "nadir-iio-XXXXXX";
    devices = mkdtemp(name.data());
  }
  ~IioTest() override { fs::remove_all(devices); }

  void write(const std::string& device, const std::string& file, const std::string& text) const {
    fs::create_directory(devices / device);
    std::ofstream(devices / device / file) << text << '\n';
  }

  void write_bno055(const std::string& device, const std::string& quaternion) const {
    write(device, "name", "bno055");
    write(device, "in_rot_quaternion_raw", quaternion);
    write(device, "in_rot_scale", "0.062500000");
    write(device, "in_magn_calibration_auto_status", "4");
    write(device, "sys_calibration_auto_status", "2");
  }

  fs::path devices;
};

// Angles apart on the circle, degrees.
double apart(double radians, double degrees) {
  return std::abs(std::remainder(radians / kDegree - degrees, 360));
}

TEST_F(IioTest, ReadsAPressureOfTheDeviceOfThatName) {
  write("iio:device0", "name", "bmp280");
  write("iio:device0", "in_pressure_input", "100.9");
  write("iio:device1", "name", "ms5837-30ba");
  write("iio:device1", "in_pressure_input", "151.203400000");
  IioDevice device(devices, "ms5837-30ba");
  EXPECT_NEAR(*device.read(0).pressure, 151203.4, 1e-6);
  EXPECT_EQ(device.fault(), "");
  EXPECT_NEAR(*IioDevice(devices, "iio:device0").read(0).pressure, 100900, 1e-6);
}

TEST_F(IioTest, WorksOutAPressureOfRawValues) {
  write("iio:device0", "name", "hsc030pa");
  write("iio:device0", "in_pressure_raw", "6000");
  write("iio:device0", "in_pressure_scale", "0.025");
  IioDevice device(devices, "hsc030pa");
  EXPECT_NEAR(*device.read(0).pressure, 150000, 1e-6);
  write("iio:device0", "in_pressure_offset", "-400");
  EXPECT_NEAR(*device.read(0).pressure, 140000, 1e-6);
}

TEST_F(IioTest, SaysWhatIsMissingAndGoesOnWhenItIsThere) {
  IioDevice device(devices, "ms5837-30ba");
  EXPECT_FALSE(device.read(0).pressure);
  EXPECT_NE(device.fault().find("no such device"), std::string::npos);
  write("iio:device0", "name", "ms5837-30ba");
  EXPECT_FALSE(device.read(0).pressure);
  EXPECT_NE(device.fault().find("no pressure"), std::string::npos);
  for (const char* bad : {"", "x", "nan", "1.5kPa", "inf"}) {
    write("iio:device0", "in_pressure_input", bad);
    EXPECT_FALSE(device.read(0).pressure) << bad;
  }
  write("iio:device0", "in_pressure_input", "101.3");
  EXPECT_TRUE(device.read(0).pressure);
  EXPECT_EQ(device.fault(), "");
  fs::remove_all(devices / "iio:device0");
  EXPECT_FALSE(device.read(0).pressure);
}

TEST_F(IioTest, TellsRollPitchAndHeadingOfABno055) {
  struct Case {
    const char* raw;  // w x y z as the kernel writes them, with a blank at the end
    double roll, pitch, heading;
  };
  // cos and sin of half the angle times 16384; chip: x right, y forward, z up.
  for (const Case& c : {Case{"16384 0 0 0 ", 0, 0, 0},             // x east, y north, z up
                        Case{"-16384 0 0 0 ", 0, 0, 0},            // the same
                        Case{"11585 0 0 -11585 ", 0, 0, 90},       // 90 about -z: y to the east
                        Case{"15137 0 0 6270 ", 0, 0, 315},        // 45 about z
                        Case{"0 0 0 16384 ", 0, 0, 180},           // y to the south
                        Case{"15826 4240 0 0 ", 0, 30, 0},         // 30 about x: y up
                        Case{"15826 -4240 0 0 ", 0, -30, 0},       // y down
                        Case{"16135 0 2845 0 ", 20, 0, 0},         // 20 about y: x down
                        Case{"11585 0 -11585 0 ", -90, 0, 0},      // left side down
                        Case{"0 0 16384 0 ", 180, 0, 0},           // lid down
                        Case{"11585 11585 0 0 ", 0, 90, 0},        // y straight up
                        Case{"8192 8192 8192 8192 ", 0, 90, 270},  // and x north
                        Case{"8192 -8192 8192 -8192 ", 0, -90, 90}}) {
    fs::remove_all(devices / "iio:device0");
    write_bno055("iio:device0", c.raw);
    IioDevice device(devices, "bno055");
    const Reading reading = device.read(0);
    EXPECT_EQ(device.fault(), "");
    ASSERT_TRUE(reading.roll && reading.pitch && reading.magnetic_heading) << c.raw;
    EXPECT_LT(apart(*reading.roll, c.roll), 0.01) << c.raw;
    EXPECT_LT(apart(*reading.pitch, c.pitch), 0.01) << c.raw;
    EXPECT_LT(apart(*reading.magnetic_heading, c.heading), 0.01) << c.raw;
    EXPECT_GE(*reading.magnetic_heading, 0);
    EXPECT_FALSE(reading.heading || reading.pressure);
  }
}

TEST_F(IioTest, TellsABno055InEveryAttitude) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  struct Case {
    double roll, pitch, heading;
  };
  for (const Case& c : {Case{10, 20, 30}, Case{-10, -20, 330}, Case{110, -40, 200},
                        Case{-150, 60, 100}, Case{-30, 89, 300}, Case{40, -89.5, 10}}) {
    // Turned to its heading, then up, then right side down, each about the chip's own axis.
    const Eigen::Quaterniond q(AngleAxisd(-kDegree * c.heading, Vector3d::UnitZ()) *
                               AngleAxisd(kDegree * c.pitch, Vector3d::UnitX()) *
                               AngleAxisd(kDegree * c.roll, Vector3d::UnitY()));
    std::string raw;
    for (const double value : {q.w(), q.x(), q.y(), q.z()})
      raw += std::to_string(std::lround(16384 * value)) + ' ';
    write_bno055("iio:device0", raw);
    const Reading reading = IioDevice(devices, "iio:device0").read(0);
    ASSERT_TRUE(reading.roll && reading.pitch && reading.magnetic_heading) << raw;
    // Half a unit of a component is 0.004 degrees; roll and heading near the vertical, more.
    const double most = 0.01 / std::cos(kDegree * c.pitch);
    EXPECT_LT(apart(*reading.roll, c.roll), most) << raw;
    EXPECT_LT(apart(*reading.pitch, c.pitch), 0.01) << raw;
    EXPECT_LT(apart(*reading.magnetic_heading, c.heading), most) << raw;
  }
}

TEST_F(IioTest, GivesNoHeadingOfABno055UntilItIsCalibrated) {
  const char* const compass = "in_magn_calibration_auto_status";
  const char* const system = "sys_calibration_auto_status";
  write_bno055("iio:device0", "16384 0 0 0 ");
  // 0: off; 1: the chip's 0.
  for (const auto& [file, status] : {std::pair{compass, "0"},
                                     {compass, "1"},
                                     {compass, ""},
                                     {system, "0"},
                                     {system, "1"},
                                     {system, "2x"}}) {
    write_bno055("iio:device0", "16384 0 0 0 ");
    write("iio:device0", file, status);
    IioDevice device(devices, "bno055");
    const Reading reading = device.read(0);
    EXPECT_TRUE(reading.roll && reading.pitch);
    EXPECT_FALSE(reading.magnetic_heading) << file << ' ' << status;
    EXPECT_NE(device.fault().find("not calibrated"), std::string::npos);
  }
  write_bno055("iio:device0", "16384 0 0 0 ");
  fs::remove(devices / "iio:device0" / system);
  EXPECT_FALSE(IioDevice(devices, "bno055").read(0).magnetic_heading);
}

TEST_F(IioTest, WaitsForACalibrationThatHolds) {
  write_bno055("iio:device0", "16384 0 0 0 ");
  IioDevice device(devices, "bno055");
  EXPECT_TRUE(device.read(0).magnetic_heading);
  write("iio:device0", "sys_calibration_auto_status", "1");
  EXPECT_TRUE(device.read(kSecond - 1).magnetic_heading);  // asked once a second
  EXPECT_FALSE(device.read(kSecond).magnetic_heading);
  write("iio:device0", "sys_calibration_auto_status", "2");
  for (int i = 2; i < 11; ++i) EXPECT_FALSE(device.read(i * kSecond).magnetic_heading) << i;
  EXPECT_TRUE(device.read(11 * kSecond).magnetic_heading);
  EXPECT_EQ(device.fault(), "");
}

TEST_F(IioTest, DoesNotUseADamagedOrientation) {
  for (const char* bad : {"", "0 0 0 0 ", "16384 0 0", "16384 0 0 0 0 ", "16384,0,0,0", "x 0 0 1",
                          "nan 0 0 16384 ", "16384 0 0 inf", "20000 0 0 0 ", "1 0 0 0 ",
                          "16384 0 0 0x ", "16384 0 0-1 0 ", "1e999 0 0 0 "}) {
    write_bno055("iio:device0", bad);
    IioDevice device(devices, "bno055");
    EXPECT_EQ(device.read(0), Reading()) << bad;
    EXPECT_NE(device.fault().find("no orientation"), std::string::npos) << bad;
    write("iio:device0", "in_rot_quaternion_raw", "16383 -3 2 1 ");
    EXPECT_TRUE(device.read(1).magnetic_heading) << bad;
  }
  write_bno055("iio:device0", std::string(1000, '1'));
  EXPECT_EQ(IioDevice(devices, "bno055").read(0), Reading());
}

TEST_F(IioTest, FindsABno055AgainThatWasUnplugged) {
  write_bno055("iio:device0", "16384 0 0 0 ");
  IioDevice device(devices, "bno055");
  EXPECT_TRUE(device.read(0).magnetic_heading);
  fs::remove_all(devices / "iio:device0");
  EXPECT_EQ(device.read(1), Reading());
  EXPECT_NE(device.fault().find("no such device"), std::string::npos);
  write_bno055("iio:device3", "11585 0 0 -11585 ");
  write("iio:device3", "sys_calibration_auto_status", "1");
  EXPECT_TRUE(device.read(2).roll);
  EXPECT_FALSE(device.read(3).magnetic_heading);  // it starts anew
}

TEST_F(IioTest, SaysWhatToDoWithoutAnOrientation) {
  const auto fault = [&](const std::string& name) {
    IioDevice device(devices, name);
    EXPECT_EQ(device.read(0), Reading());
    return device.fault();
  };
  write_bno055("iio:device0", "");
  write("iio:device0", "fusion_enable", "0");
  EXPECT_NE(fault("bno055").find("fusion_enable"), std::string::npos);
  write("iio:device1", "name", "icm20948");
  write("iio:device1", "in_accel_x_raw", "17");
  EXPECT_NE(fault("icm20948").find("no orientation; use a bno055"), std::string::npos);
  write("iio:device2", "name", "lis3mdl");
  write("iio:device2", "in_magn_x_raw", "17");
  EXPECT_NE(fault("lis3mdl").find("autopilot"), std::string::npos);
  write("iio:device3", "name", "dev_rotation");
  write("iio:device3", "in_rot_quaternion_raw", "0 0 0 16384 ");
  EXPECT_NE(fault("dev_rotation").find("bno055 only"), std::string::npos);
}

}  // namespace
}  // namespace nadir::sensors
