// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// survey/: the images of live cameras as they came, with what the sensors said, as a survey folder
// that can be replayed. Synced every few seconds: a power cut costs as many, and never the map.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "nadir/core/window.hpp"
#include "nadir/record/disk.hpp"
#include "nadir/record/dive.hpp"

namespace nadir::record {

class OriginalsFolder {
 public:
  OriginalsFolder(Disk& disk, const path& dive) : disk_(disk), folder_(dive / "survey") {}
  ~OriginalsFolder();
  OriginalsFolder(const OriginalsFolder&) = delete;
  OriginalsFolder& operator=(const OriginalsFolder&) = delete;

  /// Saves the shot's originals, if it has any and they are wanted. 0 or -errno.
  int add(const Orientation& orientation, const DiveInfo& info, Originals which);
  /// Everything saved is durable when this returns 0.
  int finish();

 private:
  int begin(const Shot& shot, const DiveInfo& info);
  int add_rows(const Shot& shot);
  int append(std::size_t table, const std::string& row);

  Disk& disk_;
  path folder_;
  bool begun_ = false;
  double convergence_ = 0;  ///< with an origin frames' yaws are the grid's; ahrs.csv has true ones
  std::array<int, 4> tables_{-1, -1, -1, -1};
  std::optional<Time> synced_;
};

/// What a power cut left of a table's last row, and of files in the making, is taken away.
void mend_originals(Disk& disk, const path& dive);

}  // namespace nadir::record
