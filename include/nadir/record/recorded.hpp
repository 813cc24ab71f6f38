// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A recorded dive given once more, so that a page can show it as it showed the dive itself.
#pragma once

#include <filesystem>
#include <functional>

#include "nadir/record/dive.hpp"

namespace nadir::record {

/// What is called with the parts of a dive, in turn.
struct Recorded {
  /// As Dive::add() was given it, but without pixels: a frame has no images, a window no poses, a
  /// mosaic is left out. Alerts that belonged to no entry come with the next one. All as published
  /// live; the revisions correct it.
  std::function<void(const Entry&)> entry;
  /// Once all entries were given: a mosaic as it lies on the disk, corrected, one row of its tiles
  /// after the other.
  std::function<void(const MosaicGrid&, const std::vector<std::shared_ptr<const Tile>>&)> mosaic;
};

/// Throws InputError when the folder is no dive, or not a single record of its journal is whole.
/// Mosaics whose files are missing or damaged are left out.
void give_again(const std::filesystem::path& dive, const Recorded& to);

}  // namespace nadir::record
