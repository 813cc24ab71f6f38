// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The dives of a folder for pages: what there is, its files, and their removal.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "folder.hpp"
#include "live_dive.hpp"
#include "nadir/record/disk.hpp"
#include "nadir/serve/call.hpp"
#include "sweeper.hpp"
#include "tar.hpp"

namespace nadir::app {

/// None when the folder has no such file.
std::optional<serve::Download> download_of(const Folder& folder, const std::string& name);

/// One thread calls it. Ids are from tables made of the names that are there; none is ever a path.
class Dives {
 public:
  /// The live dive and the disk outlive it.
  Dives(const std::filesystem::path& folder, const LiveDive& live, record::Disk& disk);

  /// Newest first: {id, name, begun, images, area_m2, bytes, complete, recording}; null where
  /// unknown. bytes: of all its files.
  nlohmann::json list();
  /// {id, name, products: [{id, name, bytes, kind}], folders: [{name, files, bytes}]}: the files of
  /// the dive and of its mosaics, or those of one of the folders. None: no such dive or folder.
  std::optional<nlohmann::json> products(const std::string& dive, const std::string& folder);
  std::optional<serve::Download> file(const std::string& dive, const std::string& file);
  /// One of its images as it was projected onto the ground.
  std::optional<serve::Download> projected(const std::string& dive, std::uint64_t image);
  /// All of it.
  std::optional<serve::Download> archive(const std::string& dive);

  /// Where it lies; none when there is no such dive, or it is being recorded.
  std::optional<std::filesystem::path> recorded(const std::string& dive) const;

  enum class Removal { done, unknown, in_use, failed };
  /// Cut off at any instant, the dive is there whole or is none any more; its room is free in time.
  Removal remove(const std::string& dive);

 private:
  // NOLINTNEXTLINE(bugprone-exception-escape): moving JSON throws nothing here
  struct Known {
    std::int64_t changed_ns = 0;  ///< of dive.json
    nlohmann::json entry;
  };
  struct Found {
    std::string name;
    Folder folder;
  };
  bool is_live(const std::string& name) const;
  std::optional<Found> find(const std::string& dive) const;
  nlohmann::json entry_of(const std::string& name, const Folder& folder);

  const std::filesystem::path folder_;
  const LiveDive& live_;
  record::Disk& disk_;
  std::map<std::string, Known> known_;  ///< complete dives by name
  /// Of the dive whose files were asked for last.
  struct Table {
    std::string dive;
    std::map<std::string, std::vector<std::string>> way_of_id;
  } table_;
  Sweeper sweeper_;  ///< of what was removed, and of removals that were cut off
};

}  // namespace nadir::app
