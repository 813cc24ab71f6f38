// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Settings as TOML: the file, the command line's assignments, and the dump.
#pragma once

#include <filesystem>
#include <string>

#include "config.hpp"

namespace nadir::app {

/// Throws InputError with file, line and column.
void read_config_file(const std::filesystem::path& file, Config& config);

/// One "room.key=value" of the command line; the value is TOML, a bare word counts as a string.
void read_assignment(const std::string& assignment, Config& config);

/// Every setting with its meaning, in the table's order; reading it back gives the same Config.
std::string dump(const Config& config);

}  // namespace nadir::app
