// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/iio.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <utility>

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

}  // namespace

IioDevice::IioDevice(fs::path devices, std::string name)
    : devices_(std::move(devices)), name_(std::move(name)) {}

bool IioDevice::find() {
  folder_.clear();
  std::error_code error;
  for (auto entry = fs::directory_iterator(devices_, error); entry != fs::directory_iterator();
       entry.increment(error)) {
    std::string name;
    std::ifstream(entry->path() / "name") >> name;
    if (name == name_ || entry->path().filename() == name_) folder_ = entry->path();
  }
  return !folder_.empty();
}

Reading IioDevice::read() {
  Reading reading;
  fault_.clear();
  std::error_code error;
  if ((folder_.empty() || !fs::exists(folder_, error)) && !find()) {
    fault_ = "no such device in " + devices_.string();
    return reading;
  }
  if (const auto pressure = pressure_of(folder_)) {
    reading.pressure = kKilopascal * *pressure;
  } else {
    fault_ = "gives no pressure";
  }
  return reading;
}

}  // namespace nadir::sensors
