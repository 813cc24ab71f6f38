// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Pressure sensors on the board, by the kernel's Industrial I/O
// (docs.kernel.org, Documentation/ABI/testing/sysfs-bus-iio).
#pragma once

#include <filesystem>
#include <string>

#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

class IioDevice {
 public:
  /// name: as the device's file `name` says, or its folder's: iio:device0. devices: the kernel's
  /// folder of them, usually /sys/bus/iio/devices.
  IioDevice(std::filesystem::path devices, std::string name);

  /// The pressure now; empty, and see fault(), when there is none.
  Reading read();
  /// What the last read() lacked, in words that complete "iio:device:NAME: ..."; empty when it was
  /// good.
  const std::string& fault() const { return fault_; }

 private:
  bool find();

  std::filesystem::path devices_;
  std::string name_;
  std::filesystem::path folder_;  ///< empty: not found
  std::string fault_;
};

}  // namespace nadir::sensors
