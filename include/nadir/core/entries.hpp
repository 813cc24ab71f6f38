// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What lies in a folder.
#pragma once

#include <filesystem>
#include <system_error>
#include <vector>

namespace nadir {

/// Paths in no order; none of a folder that cannot be read, those before the fault of one that a
/// power cut has damaged.
inline std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> entries;
  std::error_code fault;
  // In a range-based loop the step to the next would throw.
  for (std::filesystem::directory_iterator at(folder, fault), end; at != end; at.increment(fault))
    entries.push_back(at->path());
  return entries;
}

}  // namespace nadir
