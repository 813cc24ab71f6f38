// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether the board is fit for a dive: its disk, heat, supply and clock.
#pragma once

#include <filesystem>
#include <stop_token>
#include <vector>

#include "ladder.hpp"
#include "nadir/core/finding.hpp"

namespace nadir::app {

/// By writing a file of 16 MB in the dives' folder, or a part of it when told that it is enough.
Finding check_disk_speed(const std::filesystem::path& dives, const std::stop_token& enough = {});

/// Of what board_load() tells.
std::vector<Finding> check_board(const Load& load);

/// Whether the time of day is known; dives do without.
Finding check_clock();

}  // namespace nadir::app
