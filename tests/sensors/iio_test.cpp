// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/iio.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

namespace nadir::sensors {
namespace {

namespace fs = std::filesystem;

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

  fs::path devices;
};

TEST_F(IioTest, ReadsAPressureOfTheDeviceOfThatName) {
  write("iio:device0", "name", "bmp280");
  write("iio:device0", "in_pressure_input", "100.9");
  write("iio:device1", "name", "ms5837-30ba");
  write("iio:device1", "in_pressure_input", "151.203400000");
  IioDevice device(devices, "ms5837-30ba");
  EXPECT_NEAR(*device.read().pressure, 151203.4, 1e-6);
  EXPECT_EQ(device.fault(), "");
  EXPECT_NEAR(*IioDevice(devices, "iio:device0").read().pressure, 100900, 1e-6);
}

TEST_F(IioTest, WorksOutAPressureOfRawValues) {
  write("iio:device0", "name", "hsc030pa");
  write("iio:device0", "in_pressure_raw", "6000");
  write("iio:device0", "in_pressure_scale", "0.025");
  IioDevice device(devices, "hsc030pa");
  EXPECT_NEAR(*device.read().pressure, 150000, 1e-6);
  write("iio:device0", "in_pressure_offset", "-400");
  EXPECT_NEAR(*device.read().pressure, 140000, 1e-6);
}

TEST_F(IioTest, SaysWhatIsMissingAndGoesOnWhenItIsThere) {
  IioDevice device(devices, "ms5837-30ba");
  EXPECT_FALSE(device.read().pressure);
  EXPECT_NE(device.fault().find("no such device"), std::string::npos);
  write("iio:device0", "name", "ms5837-30ba");
  EXPECT_FALSE(device.read().pressure);
  EXPECT_NE(device.fault().find("no pressure"), std::string::npos);
  for (const char* bad : {"", "x", "nan", "1.5kPa", "inf"}) {
    write("iio:device0", "in_pressure_input", bad);
    EXPECT_FALSE(device.read().pressure) << bad;
  }
  write("iio:device0", "in_pressure_input", "101.3");
  EXPECT_TRUE(device.read().pressure);
  EXPECT_EQ(device.fault(), "");
  fs::remove_all(devices / "iio:device0");
  EXPECT_FALSE(device.read().pressure);
}

}  // namespace
}  // namespace nadir::sensors
