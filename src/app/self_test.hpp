// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The checks before a dive: what each finds and what to do about it.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "config.hpp"

namespace nadir::app {

enum class Verdict {
  good,
  doubtful,  ///< the dive can go on
  bad,       ///< no map, or a wrong one
  absent,    ///< there is nothing to check
};

struct Finding {
  Verdict verdict{};
  std::string item;   ///< "camera"
  std::string found;  ///< "10.0 images a second"
  std::string remedy{};
};

/// Space and speed of the dives' folder, by writing and reading back a file of 16 MB there.
std::vector<Finding> check_disk(const std::filesystem::path& dives);

/// Whether the time of day is known; dives do without.
Finding check_clock();

/// The hottest zone of sys (/sys), and whether a Raspberry Pi throttles or lacks voltage.
std::vector<Finding> check_heat(const std::filesystem::path& sys);

/// Whether each input is heard within a few seconds, and what it tells.
std::vector<Finding> check_sensors(const sensors::Config& config, std::chrono::seconds patience);

/// Cameras, light, focus, the pair and its calibration, on up to twenty images.
std::vector<Finding> check_cameras(const Config& config, std::chrono::seconds patience);

/// Whether something serves the page at this machine's port.
Finding check_page(const serve::Config& config);

}  // namespace nadir::app
