// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Reading files that a diver's card may hold in any state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nadir::capture {

struct FileBytes {
  std::vector<std::uint8_t> bytes;
  std::string fault;  ///< empty when read
};

enum class Links { refuse, follow };

/// A whole regular file of at most most_bytes. Never waits: pipes, devices and the like are faults.
FileBytes read_file(const std::filesystem::path& file, std::uint64_t most_bytes, Links links);
/// Its first bytes, at most that many.
FileBytes read_head(const std::filesystem::path& file, std::size_t bytes);

/// For messages: control characters and what is not UTF-8 become '?'.
std::string printable(const std::string& name);

}  // namespace nadir::capture
