// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The folder of all dives: the name of a new one, and the files of those that were cut off.
#pragma once

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace nadir::app {

/// One more than the highest number there: "dive-0042", and the time behind it when the clock was
/// set by another (a small computer's own begins anywhere): "dive-0042-20261129-190402".
std::filesystem::path new_dive(const std::filesystem::path& dives);

/// Whether the time of day is known: by a network or another, not just counted on since the start.
bool clock_is_set();

/// Dives that have a journal but were not finished, oldest first.
std::vector<std::filesystem::path> unfinished_dives(const std::filesystem::path& dives);

/// Recovers them one after the other, each in a process of its own at the lowest priority, so that
/// what is in them cannot harm the dive of now.
class Recoveries {
 public:
  explicit Recoveries(std::vector<std::filesystem::path> dives);
  /// Ends the one at work; it is done again next time.
  ~Recoveries() = default;

 private:
  std::jthread thread_;
};

}  // namespace nadir::app
