// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The secret that makes a page one that may command this device.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "nadir/record/disk.hpp"

namespace nadir::app {

/// In the state directory, which the package makes; without it beside the folder of all dives.
std::filesystem::path token_file(const std::filesystem::path& dives,
                                 const std::filesystem::path& state = "/var/lib/nadir");

/// 32 bytes of the system's randomness in base64url (RFC 4648, 5), 43 characters.
std::string new_token();

struct DeviceToken {
  std::string token;
  std::string message;  ///< for the log; empty when the token was there
};
/// The one that is there; else a new one, which then is: durable, and readable by its owner only.
/// Where that cannot be, it is good until the end of the program.
DeviceToken device_token(const std::filesystem::path& file, record::Disk& disk);

/// Throws InputError with the remedy when there is none that can be read.
std::string read_token(const std::filesystem::path& file);

/// In a time that tells nothing of where they differ.
bool is_same_token(std::string_view a, std::string_view b);

}  // namespace nadir::app
