// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Makes the files of a dive whose recording was cut off (nadir recover DIVE).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nadir::record {

class Disk;

struct Recovery {
  std::uint64_t captured = 0, oriented = 0, lost = 0, dropped = 0;  ///< images, as in dive.json
  std::uint64_t missing_records = 0;  ///< written to the journal, but damaged since
  std::uint64_t projected = 0;        ///< projected images that are whole
  std::vector<std::string> damaged;   ///< files that cannot be made again, or could not be written
  std::vector<std::string> made;      ///< loose files made by this call
  bool was_complete = false;          ///< the dive had been finished or recovered before
  bool cut_off = false;               ///< its recording did not come to its end

  /// Nothing that was ever recorded is lost.
  bool whole() const { return missing_records == 0 && damaged.empty(); }
};

/// May be called at any time, also on a complete dive, and cut off at any instant: the journal is
/// only read. A loose file that is whole is left alone; one that changed since it was written is
/// kept beside the new one as NAME.changed. Throws InputError when the folder is not a dive, is
/// being recorded, was written by a later version, or has no whole record.
Recovery recover(const std::filesystem::path& dive);
Recovery recover(const std::filesystem::path& dive, Disk& disk);

/// Whether the dive was finished or recovered: dive.json is there.
bool is_complete(const std::filesystem::path& dive);

}  // namespace nadir::record
