// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A recorded dive given once more, so that a page can show it as it showed the dive itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

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
  /// A mark that was put or removed, between the entries where it was; may be empty.
  std::function<void(const Mark&)> mark{};
};

/// What a dive was found to be.
struct GivenAgain {
  std::uint64_t captured = 0;          ///< images that the journal counts
  std::uint64_t missing_records = 0;   ///< written to the journal, but damaged since
  std::uint64_t mosaics_left_out = 0;  ///< whose files are missing or damaged
  /// Images by a dive.json from before the journal lost its end; none when it did not.
  std::optional<std::uint64_t> captured_once;
};

/// Throws InputError when the folder is no dive, or not a single record of its journal is whole.
/// When told to stop it returns between two records or rows of tiles.
GivenAgain give_again(const std::filesystem::path& dive, const Recorded& to,
                      const std::stop_token& stop = {});

}  // namespace nadir::record
