// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace nadir::calibration {

/// A text file read whole, without its byte order mark. Throws InputError when it cannot be read,
/// is no regular file, is larger than 1 MB, empty, or binary.
std::string read_text(const std::filesystem::path& file);

}  // namespace nadir::calibration
