// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/recover.hpp"

#include <algorithm>

#include "earlier_summary.hpp"
#include "nadir/core/check.hpp"
#include "originals_folder.hpp"
#include "products.hpp"
#include "projected_folder.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

/// Throws InputError when dive.json could not be written again.
void check_summary(const path& dive) {
  const path name = dive / "dive.json";
  std::error_code error;
  if (std::filesystem::is_directory(name, error)) {
    throw InputError(name.string() + ": is a folder; move it away and recover again");
  }
}

/// The loose files that are there.
struct Found {
  Stamps whole;  ///< as dive.json has them
  std::set<std::string> changed;
};

Found find_files(const path& dive, const Stamps& written) {
  Found found;
  for (const auto& [name, stamp] : written) {
    const auto now = stamp_of(dive / name);
    if (now == stamp) {
      found.whole[name] = stamp;
    } else if (now) {
      found.changed.insert(name);
    }
  }
  return found;
}

bool is_mosaic(const std::string& name) { return name.starts_with("mosaic2d/"); }

bool mosaics_are_whole(const EarlierSummary& previous, const Found& found) {
  return previous.exists && std::ranges::all_of(previous.files, [&](const auto& file) {
           return !is_mosaic(file.first) || found.whole.contains(file.first);
         });
}

void settle_projected(Disk& disk, const path& dive, const Ledger& ledger, bool was_complete,
                      Recovery& recovery) {
  const std::string auxiliary = auxiliary_xml(ledger);
  for (const auto& [file, submap, plane] : ledger.projected) {
    if (settle(disk, dive, file, ledger.grid, auxiliary, {true, was_complete})) {
      ++recovery.projected;
    } else {
      recovery.damaged.push_back("projected/" + padded(file.image, 6) + ".png");
    }
  }
}

void count(const Ledger& ledger, const EarlierSummary& previous, Recovery& recovery) {
  const ImageCounts counts = ledger.counts();
  recovery.captured = counts.captured;
  recovery.oriented = counts.oriented;
  recovery.lost = counts.lost;
  recovery.dropped = counts.dropped();
  recovery.missing_records = ledger.missing_records;
  recovery.was_complete = previous.exists;
  recovery.cut_off = !ledger.ended;
  // At least the end.
  if (previous.outlives(ledger) && recovery.missing_records == 0) recovery.missing_records = 1;
}

void note_failures(const EarlierSummary& previous, const Outcome& outcome, Recovery& recovery) {
  recovery.made = outcome.made;
  for (const auto& [name, error] : outcome.failed) recovery.damaged.push_back(name);
  for (const std::string& name : outcome.lost) recovery.damaged.push_back(name);
  for (const auto& [name, stamp] : previous.files) {
    if (!outcome.stamps.contains(name) && !outcome.failed.contains(name) &&
        !outcome.lost.contains(name)) {
      recovery.damaged.push_back(name);
    }
  }
}

}  // namespace

Recovery recover(const path& dive) { return recover(dive, system_disk()); }

Recovery recover(const path& dive, Disk& disk) {
  const FolderLock lock(dive);
  if (has_journal(dive) && !lock.held()) {
    throw InputError(dive.string() + ": is being recorded; end the recording first");
  }
  Ledger ledger = read_ledger(dive);
  check_summary(dive);
  const EarlierSummary previous = read_summary(dive);
  Recovery recovery;
  count(ledger, previous, recovery);
  settle_projected(disk, dive, ledger, previous.exists, recovery);
  remove_leftovers(disk, dive);
  mend_originals(disk, dive);
  const Found found = find_files(dive, previous.files);
  // Corrected mosaics are always made again: the summary counts their tiles.
  const bool rebuild = !mosaics_are_whole(previous, found) || is_moved(ledger);
  const MosaicTiles tiles = rebuild ? rebuilt_tiles(dive, ledger) : MosaicTiles();
  const Outcome outcome = make_products(disk, dive, ledger, tiles, found.whole, found.changed);
  note_failures(previous, outcome, recovery);
  if (rebuild) std::ranges::move(incomplete_mosaics(ledger), std::back_inserter(recovery.damaged));
  const bool changed = !recovery.was_complete || !outcome.made.empty();
  if (changed && outcome.failed.empty()) {
    const double area = rebuild ? covered_area(ledger, tiles) : previous.area;
    const json made = summary(ledger, area, outcome.stamps, previous.rates);
    const int error = write_summary(disk, dive, made);
    if (error != 0) recovery.damaged.push_back("dive.json");
  }
  return recovery;
}

bool is_complete(const path& dive) {
  std::error_code error;
  return std::filesystem::exists(dive / "dive.json", error);
}

}  // namespace nadir::record
