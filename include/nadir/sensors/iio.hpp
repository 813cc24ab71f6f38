// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Sensors on the board, by the kernel's Industrial I/O
// (docs.kernel.org, Documentation/ABI/testing/sysfs-bus-iio).
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "nadir/core/time.hpp"
#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

/// A pressure sensor, or Bosch's BNO055, which works out its own orientation. The body is then the
/// chip: forward its y, right its x, down into the board it lies on, lid up.
class IioDevice {
 public:
  /// name: as the device's file `name` says, or its folder's: iio:device0. devices: the kernel's
  /// folder of them, usually /sys/bus/iio/devices.
  IioDevice(std::filesystem::path devices, std::string name);

  /// The pressure; or roll, pitch and, once the compass is calibrated, the magnetic heading. What
  /// is not there is absent, see fault(). now: of a clock that never steps.
  Reading read(Time now);
  /// What the last read() lacked, in words that complete "iio:device:NAME: ..."; empty when it was
  /// good.
  const std::string& fault() const { return fault_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Close>;

  bool find();
  Reading read_bno055(Time now);
  bool heading_is_good(Time now);

  std::filesystem::path devices_;
  std::string name_;
  std::filesystem::path folder_;  ///< empty: not found
  std::string fault_;

  bool is_bno055_ = false;
  File quaternion_, compass_status_, system_status_;  ///< open while folder_ is known
  std::optional<Time> checked_;                       ///< when, both states
  int distrust_ = 0;                                  ///< good checks until there is a heading
};

}  // namespace nadir::sensors
