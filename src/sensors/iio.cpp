// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/iio.hpp"

#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "angle.hpp"
#include "nadir/core/entries.hpp"

namespace nadir::sensors {

namespace fs = std::filesystem;

namespace {

constexpr double kKilopascal = 1000;

std::optional<double> number_in(const fs::path& file) {
  std::string text;
  if (!(std::ifstream(file) >> text)) return std::nullopt;
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && std::isfinite(value) ? std::optional(value)
                                                                     : std::nullopt;
}

// As it is, or of a raw value with its offset and scale. Kilopascal, says the ABI.
std::optional<double> pressure_of(const fs::path& folder) {
  if (const auto processed = number_in(folder / "in_pressure_input")) return processed;
  const auto raw = number_in(folder / "in_pressure_raw");
  const auto scale = number_in(folder / "in_pressure_scale");
  if (!raw || !scale) return std::nullopt;
  return (*raw + number_in(folder / "in_pressure_offset").value_or(0)) * *scale;
}

// What `file` says now, exactly n numbers: each read from its start has the kernel ask the sensor.
template <std::size_t n>
std::optional<std::array<double, n>> numbers_in(std::FILE* file) {
  std::array<char, 128> buffer{};
  const ssize_t size = file ? pread(fileno(file), buffer.data(), buffer.size(), 0) : 0;
  std::string_view text(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  std::array<double, n> values{};
  for (double& value : values) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
    if (!text.empty() && text.front() != ' ' && text.front() != '\n') return std::nullopt;
  }
  return text.find_first_not_of(" \n") == text.npos ? std::optional(values) : std::nullopt;
}

// Of a BNO055. Its driver tells w first, against the ABI's x y z w, and no scale: in_rot_scale is
// that of the Euler angles, which are left alone, as each would be of another moment.
std::optional<Eigen::Quaterniond> enu_from_chip(std::FILE* file) {
  constexpr double kUnit = 1 << 14, kTolerance = 0.02;  // data sheet, table 3-31
  const auto raw = numbers_in<4>(file);
  if (!raw) return std::nullopt;
  const auto [w, x, y, z] = *raw;
  const Eigen::Quaterniond q(w / kUnit, x / kUnit, y / kUnit, z / kUnit);
  if (!(std::abs(q.norm() - 1) < kTolerance)) return std::nullopt;  // zeros until it has started
  return q.normalized();
}

void set_attitude(Reading& reading, const Eigen::Quaterniond& enu_from_chip) {
  // East-north-up to north-east-down, and the chip's axes to the body's: the same swap.
  const Eigen::Quaterniond& q = enu_from_chip;
  const Eigen::Matrix3d ned_from_body =
      Eigen::Quaterniond(q.w(), q.y(), q.x(), -q.z()).toRotationMatrix();
  const auto& r = ned_from_body;
  const double level = std::hypot(r(0, 0), r(1, 0));
  reading.pitch = std::atan2(-r(2, 0), level);
  // Straight up or down, roll and heading turn about the same axis.
  constexpr double kStraight = 1e-9;
  const bool straight = level < kStraight;
  reading.roll = straight ? 0 : std::atan2(r(2, 1), r(2, 2));
  reading.magnetic_heading =
      as_heading(straight ? std::atan2(-r(0, 1), r(1, 1)) : std::atan2(r(1, 0), r(0, 0)));
}

// Of a device without pressure.
std::string lack_of(const fs::path& folder) {
  const auto has = [&](const char* file) {
    std::error_code error;
    return fs::exists(folder / file, error);
  };
  if (has("in_rot_quaternion_raw") || has("in_rot_yaw_raw") || has("in_incli_x_raw")) {
    return "gives angles whose axes and order are known here of the bno055 only; use an AHRS "
           "(nmea) or an autopilot (mavlink)";
  }
  if (has("in_accel_x_raw") || has("in_anglvel_x_raw") || has("in_magn_x_raw")) {
    return "gives accelerations, rates or the magnetic field, but no orientation; use a bno055, an "
           "AHRS (nmea) or an autopilot (mavlink), which work it out";
  }
  return "gives no pressure";
}

}  // namespace

IioDevice::IioDevice(fs::path devices, std::string name)
    : devices_(std::move(devices)), name_(std::move(name)) {}

bool IioDevice::find() {
  folder_.clear();
  std::string found;
  for (const fs::path& entry : entries_of(devices_)) {
    std::string name;
    std::ifstream(entry / "name") >> name;
    if (name != name_ && entry.filename() != name_) continue;
    folder_ = entry;
    found = name;
  }
  const auto open = [&](const char* file) {
    return File(is_bno055_ ? std::fopen((folder_ / file).c_str(), "re") : nullptr);
  };
  is_bno055_ = found == "bno055";
  quaternion_ = open("in_rot_quaternion_raw");
  compass_status_ = open("in_magn_calibration_auto_status");
  system_status_ = open("sys_calibration_auto_status");
  checked_.reset();
  return !folder_.empty();
}

Reading IioDevice::read(Time now) {
  Reading reading;
  fault_.clear();
  std::error_code error;
  if ((folder_.empty() || !fs::exists(folder_, error)) && !find()) {
    fault_ = "no such device in " + devices_.string();
    return reading;
  }
  if (is_bno055_) return read_bno055(now);
  if (const auto pressure = pressure_of(folder_)) {
    reading.pressure = kKilopascal * *pressure;
  } else {
    fault_ = lack_of(folder_);
  }
  return reading;
}

Reading IioDevice::read_bno055(Time now) {
  Reading reading;
  auto orientation = enu_from_chip(quaternion_.get());
  if (!orientation) orientation = enu_from_chip(quaternion_.get());  // was it garbled on the way?
  if (!orientation) {
    fault_ = number_in(folder_ / "fusion_enable") == 0
                 ? "gives no orientation until 1 is written to its fusion_enable"
                 : "gives no orientation";
    folder_.clear();  // it may have gone and come back: its files are opened anew
    return reading;
  }
  set_attitude(reading, *orientation);
  if (!heading_is_good(now)) {
    reading.magnetic_heading.reset();
    fault_ = "gives no heading, its compass is not calibrated; turn it about all axes";
  }
  return reading;
}

// Until the chip has found north its heading counts from wherever it lay.
bool IioDevice::heading_is_good(Time now) {
  constexpr Time kPeriod = 1'000'000'000;
  constexpr double kCalibrated = 2;  // the driver adds one to the chip's 0..3; its 0: switched off
  constexpr int kAgain = 10;  // seconds: a status that wavers makes no heading that comes and goes
  if (checked_ && now - *checked_ < kPeriod) return distrust_ == 0;
  const auto good = [](const File& file) {
    const auto status = numbers_in<1>(file.get());
    return status && status->front() >= kCalibrated;
  };
  const bool calibrated = good(compass_status_) && good(system_status_);
  distrust_ = calibrated ? std::max(distrust_ - 1, 0) : kAgain;
  checked_ = now;
  return distrust_ == 0;
}

}  // namespace nadir::sensors
