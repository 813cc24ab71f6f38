// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What is given up first when the board cannot do everything: images and poses are always recorded.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace nadir::app {

/// What the firmware of a Raspberry Pi does now.
struct Throttling {
  bool weak_supply = false;  ///< the voltage is too low
  bool slowed_down = false;  ///< mostly by heat
};

/// What the board has to bear. Unknown is none.
struct Load {
  double dropped = 0;  ///< of the images and windows of the last seconds, those that found no room
  std::optional<double> temperature_deg{};
  std::optional<Throttling> throttling{};
  std::optional<double> memory{};  ///< used, of what the service may use
  std::optional<double> free_disk_gb{};
  std::optional<double> battery{};  ///< left, of full
};

/// sys: /sys; dives: whose disk counts. dropped is left to the caller.
Load board_load(const std::filesystem::path& sys, const std::filesystem::path& dives);

/// The steps, each with all before it.
enum class Economy {
  none,
  live_image,  ///< twice a second instead of ten times
  mosaic,      ///< at half the resolution
  projection,  ///< a planar cloud of every fourth image
};
inline constexpr Economy kMostEconomy = Economy::projection;
std::string in_words(Economy economy);

class Ladder {
 public:
  using Clock = std::chrono::steady_clock;

  /// To be called every second or so. A step is taken when a limit was passed for 5 s and the last
  /// step did not help for 10 s; one is taken back after a minute within all limits.
  Economy observe(Clock::time_point now, const Load& load);
  /// Why it took the last step.
  const std::string& reason() const { return reason_; }

 private:
  Economy economy_ = Economy::none;
  std::optional<Clock::time_point> over_since_, within_since_;
  Clock::time_point changed_{};
  std::string reason_;
};

}  // namespace nadir::app
