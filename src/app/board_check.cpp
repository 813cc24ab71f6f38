// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "board_check.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "earlier_dives.hpp"
#include "nadir/core/rounded.hpp"

namespace nadir::app {

namespace fs = std::filesystem;

namespace {

// Megabytes a second, each block written through to the disk as the journal is; 0 with errno.
double write_speed(const fs::path& file, const std::stop_token& enough) {
  constexpr std::size_t kBlock = 1 << 20, kBlocks = 16;
  ::unlink(file.c_str());
  const int to = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (to < 0) return 0;
  ::unlink(file.c_str());  // it goes with this process, however that ends
  std::vector<char> block(kBlock);
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = static_cast<char>(i * 2654435761u >> 7);
  const auto begin = std::chrono::steady_clock::now();
  std::size_t written = 0;
  bool good = true;
  do {
    good = ::write(to, block.data(), block.size()) == static_cast<ssize_t>(block.size()) &&
           ::fdatasync(to) == 0;
    written += block.size();
  } while (good && written < kBlock * kBlocks && !enough.stop_requested());
  const int error = errno;
  ::close(to);
  errno = error;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  return good ? static_cast<double>(written) / 1e6 / took.count() : 0;
}

Finding check_space(double free_gb) {
  constexpr double kLittle_gb = 2;
  const bool little = free_gb < kLittle_gb;
  return {little ? Verdict::doubtful : Verdict::good, "disk space", rounded(free_gb) + " GB free",
          little ? "copy earlier dives away and delete them" : ""};
}

Finding check_temperature(double degrees) {
  constexpr double kHot_deg = 75;  // a Raspberry Pi slows down from 80
  const bool hot = degrees >= kHot_deg;
  return {hot ? Verdict::doubtful : Verdict::good, "temperature", rounded(degrees, 0) + " degrees",
          hot ? "cool the housing; in water it will be cooler" : ""};
}

Finding check_throttling(const Throttling& now) {
  if (now.weak_supply) {
    return {Verdict::doubtful, "throttling", "the supply's voltage is too low",
            "use a stronger supply or thicker cables"};
  }
  if (now.slowed_down) {
    return {Verdict::doubtful, "throttling", "the processor is slowed down by heat",
            "cool the housing"};
  }
  return {Verdict::good, "throttling", "none now"};
}

Finding check_battery(double part) {
  constexpr double kLow = 0.3;
  const bool low = part < kLow;
  return {low ? Verdict::doubtful : Verdict::good, "battery", rounded(100 * part, 0) + " % left",
          low ? "charge it before the dive" : ""};
}

}  // namespace

Finding check_disk_speed(const fs::path& dives, const std::stop_token& enough) {
  fs::path there = dives;  // or where it will be
  std::error_code error;
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const double speed = write_speed(there / ".speed-test", enough);
  const std::string reason = std::strerror(errno);
  if (speed == 0) {
    return {Verdict::bad, "disk speed", dives.string() + " cannot be written: " + reason,
            "check the disk, its mount and record.dives"};
  }
  constexpr double kSlow = 3;  // megabytes a second that projected images take at 5 Hz
  return {speed < kSlow ? Verdict::doubtful : Verdict::good, "disk speed",
          rounded(speed) + " MB a second, written through",
          speed < kSlow ? "use a faster card; images may not all be saved" : ""};
}

std::vector<Finding> check_board(const Load& load) {
  std::vector<Finding> findings;
  if (load.free_disk_gb) findings.push_back(check_space(*load.free_disk_gb));
  if (load.temperature_deg) {
    findings.push_back(check_temperature(*load.temperature_deg));
  } else {
    findings.push_back({Verdict::absent, "temperature", "is not measured here"});
  }
  if (load.throttling) findings.push_back(check_throttling(*load.throttling));
  if (load.battery) findings.push_back(check_battery(*load.battery));
  return findings;
}

Finding check_clock() {
  if (clock_is_set()) return {Verdict::good, "clock", "set by another"};
  return {Verdict::absent, "clock", "not set by another: dives are named by their number only"};
}

}  // namespace nadir::app
