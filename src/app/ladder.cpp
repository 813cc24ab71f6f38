// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "ladder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "nadir/core/entries.hpp"

namespace nadir::app {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

constexpr auto kPatience = 5s, kEffect = 10s, kRelief = 60s;

// Limits to step down at, and to stay within before a step is taken back.
constexpr double kDropped = 0.05, kFewDropped = 0.01;
constexpr double kHot_deg = 80, kWarm_deg = 75;  // a Raspberry Pi slows down from 80
constexpr double kFull = 0.85, kHalfFull = 0.75;
constexpr double kLittle_gb = 1, kEnough_gb = 2;
constexpr double kLow = 0.15, kCharged = 0.25;

std::optional<double> number_in(const fs::path& file, int base = 10) {
  std::string text;
  if (!(std::ifstream(file) >> text)) return std::nullopt;
  char* end = nullptr;
  const double value = static_cast<double>(std::strtoll(text.c_str(), &end, base));
  return *end == '\0' && end != text.c_str() ? std::optional(value) : std::nullopt;
}

// The values of FOLDER/*/NAME; entries without one are passed over.
std::vector<double> numbers_in(const fs::path& folder, const char* name) {
  std::vector<double> found;
  for (const fs::path& entry : entries_of(folder)) {
    if (const auto value = number_in(entry / name)) found.push_back(*value);
  }
  return found;
}

// Of this process's control group, under cgroup v2: "0::/system.slice/nadir.service".
std::optional<double> memory_used(const fs::path& sys) {
  std::string line;
  std::ifstream groups("/proc/self/cgroup");
  constexpr std::string_view kVersion2 = "0::/";
  while (std::getline(groups, line) && !line.starts_with(kVersion2)) {
  }
  if (!line.starts_with(kVersion2)) return std::nullopt;
  const fs::path group = sys / "fs/cgroup" / line.substr(kVersion2.size());
  const auto most = number_in(group / "memory.max"), used = number_in(group / "memory.current");
  // What the kernel keeps of files goes when it is needed.
  double files = 0;
  std::ifstream stat(group / "memory.stat");
  for (std::string name; stat >> name;) {
    double bytes = 0;
    stat >> bytes;
    if (name == "file") files = bytes;
  }
  return most && used && *most > 0 ? std::optional((*used - files) / *most) : std::nullopt;
}

// The firmware's node lies below that of the processor, whose name has its address on a Pi 5.
std::optional<unsigned> throttling_bits(const fs::path& sys) {
  constexpr int kHexadecimal = 16;
  for (const fs::path& soc : entries_of(sys / "devices/platform")) {
    const std::string name = soc.filename().string();
    if (!name.starts_with("soc")) continue;
    const auto bits = number_in(soc / (name + ":firmware") / "get_throttled", kHexadecimal);
    if (bits) return static_cast<unsigned>(*bits);
  }
  return std::nullopt;
}

std::string percent(double part) { return std::to_string(std::lround(100 * part)) + " %"; }

bool is_throttled(const Load& load) {
  return load.throttling && (load.throttling->weak_supply || load.throttling->slowed_down);
}

// Why something has to be given up; empty when nothing.
std::string over(const Load& load) {
  if (load.dropped > kDropped)
    return "the processor cannot keep up, " + percent(load.dropped) + " of the images were dropped";
  if (load.temperature_deg && *load.temperature_deg >= kHot_deg)
    return "the board is " + std::to_string(std::lround(*load.temperature_deg)) + " degrees hot";
  if (is_throttled(load)) return "the board is slowed down by heat or a weak supply";
  if (load.memory && *load.memory > kFull) return percent(*load.memory) + " of the memory is used";
  if (load.free_disk_gb && *load.free_disk_gb < kLittle_gb)
    return "the disk has less than 1 GB left";
  if (load.battery && *load.battery < kLow)
    return "the battery has " + percent(*load.battery) + " left";
  return {};
}

bool is_well_within(const Load& load) {
  return load.dropped <= kFewDropped && load.temperature_deg.value_or(0) < kWarm_deg &&
         !is_throttled(load) && load.memory.value_or(0) < kHalfFull &&
         load.free_disk_gb.value_or(kEnough_gb) >= kEnough_gb &&
         load.battery.value_or(1) >= kCharged;
}

}  // namespace

Load board_load(const fs::path& sys, const fs::path& dives) {
  Load load;
  const std::vector<double> zones = numbers_in(sys / "class/thermal", "temp");
  if (!zones.empty()) load.temperature_deg = 1e-3 * std::ranges::max(zones);
  // Bits of now: 0 voltage too low, 1 and 2 slowed down.
  constexpr unsigned kWeak = 0b001, kSlowed = 0b110;
  if (const auto bits = throttling_bits(sys))
    load.throttling = Throttling{(*bits & kWeak) != 0, (*bits & kSlowed) != 0};
  load.memory = memory_used(sys);
  std::error_code error;
  const fs::space_info space = fs::space(dives, error);
  if (!error) load.free_disk_gb = 1e-9 * static_cast<double>(space.available);
  const std::vector<double> batteries = numbers_in(sys / "class/power_supply", "capacity");
  if (!batteries.empty()) load.battery = 0.01 * std::ranges::max(batteries);
  return load;
}

std::string in_words(Economy economy) {
  switch (economy) {
    case Economy::none:
      return "everything as it should be";
    case Economy::live_image:
      return "the live image twice a second";
    case Economy::mosaic:
      return "the live image twice a second, mosaics at half the resolution";
    case Economy::projection:
      return "the live image twice a second, mosaics at half the resolution, planar clouds of "
             "every "
             "fourth image";
  }
  return {};
}

Economy Ladder::observe(Clock::time_point now, const Load& load) {
  const std::string why = over(load);
  const bool within = is_well_within(load);
  if (why.empty()) over_since_.reset();
  if (!within) within_since_.reset();
  if (!why.empty() && !over_since_) over_since_ = now;
  if (within && !within_since_) within_since_ = now;
  const bool settled = changed_ == Clock::time_point{} || now - changed_ >= kEffect;
  if (over_since_ && now - *over_since_ >= kPatience && settled && economy_ < kMostEconomy) {
    economy_ = static_cast<Economy>(static_cast<int>(economy_) + 1);
    changed_ = now;
    reason_ = why;
  } else if (within_since_ && now - *within_since_ >= kRelief && economy_ > Economy::none) {
    economy_ = static_cast<Economy>(static_cast<int>(economy_) - 1);
    changed_ = now;
    within_since_ = now;  // another minute for the next
    reason_ = "there is room again";
  }
  return economy_;
}

}  // namespace nadir::app
