// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/dive.hpp"

#include <algorithm>
#include <iterator>

#include "nadir/core/check.hpp"
#include "originals_folder.hpp"
#include "products.hpp"
#include "projected_folder.hpp"

namespace nadir::record {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPending = 1000;  // alerts that wait for the disk

enum class Condition { saving, without_images, paused };

// At any depth; fault: why it is not known.
bool holds_files(const path& folder, std::error_code& fault) {
  constexpr auto kOptions = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator at(folder, kOptions, fault), end; at != end;
       at.increment(fault)) {
    if (!at->is_directory(fault)) return true;
  }
  return false;
}

[[noreturn]] void refuse(const path& folder, std::string_view fault, std::string_view remedy) {
  throw InputError(folder.string() + ": " + std::string(fault) + "; " + std::string(remedy));
}

Alert unfinished(const std::string& reason) {
  Alert alert;
  alert.kind = AlertKind::storage;
  alert.message = "not all files of the dive were written: " + reason;
  alert.remedy = "free space on the disk, then run: nadir recover";
  return alert;
}

void require(int result, const path& folder) {
  constexpr std::string_view kRemedy = "check the path, its permissions and the space on the disk";
  if (result < 0) refuse(folder, describe(result), kRemedy);
}

/// Those that were made go again unless they are kept: a dive that is tried until it begins leaves
/// no heap of them.
class Folders {
 public:
  explicit Folders(Disk& disk) : disk_(disk) {}
  ~Folders() {
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) disk_.remove(*folder);
  }
  Folders(const Folders&) = delete;
  Folders& operator=(const Folders&) = delete;

  /// One that is there already will do.
  void make(const path& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error)) return;
    require(disk_.make_directory(folder), folder);
    made_.push_back(folder);
  }
  void keep() { made_.clear(); }

 private:
  Disk& disk_;
  std::vector<path> made_;
};

// Its absolute name.
path begin_folder(Disk& disk, Folders& folders, const path& folder) {
  path name = fs::absolute(folder).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();  // "dives/today/"
  std::error_code error;
  fs::create_directories(name.parent_path(), error);
  folders.make(name);
  require(sync_directory(disk, name.parent_path()), name);
  return name;
}

void require_unused(const path& folder, const FolderLock& lock) {
  constexpr std::string_view kRemedy = "choose another folder";
  if (!lock.held()) refuse(folder, "is being recorded by another program", kRemedy);
  if (has_journal(folder)) refuse(folder, "already holds a dive", kRemedy);
  std::error_code fault;
  if (holds_files(folder, fault)) refuse(folder, "is not empty", kRemedy);
  if (fault) refuse(folder, "cannot be read: " + fault.message(), kRemedy);
}

std::string describe(Condition from, Condition to, int error, std::uint64_t unsaved) {
  const std::string reason(record::describe(error)), count = std::to_string(unsaved);
  switch (to) {
    case Condition::paused:
      return "recording paused: " + reason;
    case Condition::without_images:
      return "projected images are not saved: " + reason;
    case Condition::saving:
      break;
  }
  return (from == Condition::paused ? "recording again; images not recorded: "
                                    : "projected images are saved again; not saved: ") +
         count + ", which a correction or recovery of the mosaics will lack";
}

Alert storage_alert(const Facts& facts, std::string message, bool trouble) {
  constexpr std::string_view kRemedy =
      "free space on the disk or replace it; recording goes on by itself when it can";
  return {facts.time, facts.image, trouble ? AlertKind::storage : AlertKind::storage_back,
          std::move(message), trouble ? std::string(kRemedy) : std::string("none needed")};
}

}  // namespace

struct Dive::State {
  State(Disk& disk_used, const path& dive, const Config& configured)
      : disk(disk_used),
        folders(disk),
        folder(begin_folder(disk, folders, dive)),
        config(configured),
        lock(folder),
        journal(disk, folder),
        projected(disk, folder),
        originals(disk, folder) {
    require_unused(folder, lock);
    folders.make(folder / "projected");
    folders.make(folder / "mosaic2d");
  }

  int save_projected(const Entry& entry, Facts& facts);
  std::vector<Alert> conclude_originals(const Facts& facts, int error);
  std::vector<Alert> conclude(const Facts& facts, int image_error, int journal_error);
  void record_pending();
  std::vector<Alert> make_files(const nlohmann::json& rates);

  Disk& disk;
  Folders folders;
  path folder;
  Config config;
  FolderLock lock;
  JournalWriter journal;
  ProjectedFolder projected;
  OriginalsFolder originals;
  DiveInfo info;
  bool originals_fail = false;
  MosaicTiles tiles;
  Condition condition = Condition::saving;
  std::vector<Alert> pending;  ///< alerts the journal does not have yet
  std::vector<std::shared_ptr<const Revision>> unsaved_revisions;
  std::uint64_t unsaved = 0;  ///< since the condition was last good
  std::uint64_t seen = 0, saved = 0;
  std::uint64_t captured = 0;
};

std::vector<Alert> Dive::State::make_files(const nlohmann::json& rates) {
  Ledger ledger = read_ledger(folder);
  const std::string auxiliary = auxiliary_xml(ledger);
  for (const auto& projected_facts : ledger.projected) {
    settle(disk, folder, projected_facts.file, ledger.grid, auxiliary, {});
  }
  remove_leftovers(disk, folder);
  // Without projected images the tiles stay as they were made, and only their place is corrected.
  if (is_moved(ledger)) {
    std::erase_if(tiles, [&](const auto& tile) {
      return ledger.mosaic_first_image.contains(tile.first.mosaic);
    });
    MosaicTiles rebuilt = rebuilt_tiles(folder, ledger);
    tiles.merge(rebuilt);
  }
  const Outcome outcome = make_products(disk, folder, ledger, tiles, {}, {});
  if (!outcome.failed.empty()) {
    const auto& [name, error] = *outcome.failed.begin();
    return {unfinished(name + ": " + std::string(record::describe(error)))};
  }
  const double area = covered_area(ledger, tiles);
  const int error = write_summary(disk, folder, summary(ledger, area, outcome.stamps, rates));
  if (error != 0) return {unfinished("dive.json: " + std::string(record::describe(error)))};
  std::vector<Alert> lacking;
  if (is_moved(ledger)) {
    for (const std::string& mosaic : incomplete_mosaics(ledger)) {
      lacking.push_back({0, std::nullopt, AlertKind::storage,
                         "made again from corrected poses, " + mosaic,
                         "replay the images into a folder with more space"});
    }
  }
  return lacking;
}

int Dive::State::save_projected(const Entry& entry, Facts& facts) {
  if (!config.projected || !entry.mosaic || !entry.mosaic->projected) return 0;
  NADIR_CHECK(entry.mosaic->grid, facts.image);
  const auto effort = config.small_png ? image_io::PngEffort::small : image_io::PngEffort::fast;
  ProjectedFile file;
  file.mosaic = entry.mosaic->grid->mosaic;
  const int error = projected.write(*entry.mosaic->projected, effort, file);
  if (error == 0) facts.projected = file;
  return error;
}

std::vector<Alert> Dive::State::conclude(const Facts& facts, int image_error, int journal_error) {
  const Condition now = journal_error != 0 ? Condition::paused
                        : image_error != 0 ? Condition::without_images
                                           : Condition::saving;
  const int error = journal_error != 0 ? journal_error : image_error;
  if (now != Condition::saving) ++unsaved;
  if (now == condition) return {};
  const Alert alert =
      storage_alert(facts, describe(condition, now, error, unsaved), now != Condition::saving);
  if (now == Condition::saving) unsaved = 0;
  condition = now;
  pending.push_back(alert);
  return {alert};
}

std::vector<Alert> Dive::State::conclude_originals(const Facts& facts, int error) {
  const bool fail = error < 0;
  if (std::exchange(originals_fail, fail) == fail) return {};
  pending.push_back(
      storage_alert(facts,
                    fail ? "original images are not saved: " + std::string(record::describe(error))
                         : "original images are saved again",
                    fail));
  return {pending.back()};
}

void Dive::State::record_pending() {
  if (pending.empty()) return;
  std::vector<Bytes> payloads;
  for (const Alert& alert : pending) payloads.push_back(encode(alert));
  const std::vector<ByteView> views(payloads.begin(), payloads.end());
  if (journal.append(RecordType::alert, views) == 0) pending.clear();
}

void Config::check() const { require_setting(!dives.empty(), "record.dives", "a folder"); }

Dive::Dive(const fs::path& folder, const DiveInfo& info, const Config& config)
    : Dive(folder, info, config, system_disk()) {}

Dive::Dive(const fs::path& folder, const DiveInfo& info, const Config& config, Disk& disk) {
  config.check();
  state_ = std::make_unique<State>(disk, folder, config);
  state_->info = info;
  require(state_->journal.append(RecordType::begin, encode_begin(begin_facts(info))), folder);
  state_->folders.keep();
}

Dive::~Dive() = default;

std::vector<Alert> Dive::add(const Entry& entry) {
  State& s = *state_;
  Entry whole = entry;
  whole.revisions.insert(whole.revisions.begin(), s.unsaved_revisions.begin(),
                         s.unsaved_revisions.end());
  Facts facts = facts_of(whole);
  if (facts.of_shot) {
    ++s.seen;
    s.captured = std::max(s.captured, facts.image + 1);
  }
  const int image_error = s.save_projected(entry, facts);
  facts.alerts.insert(facts.alerts.begin(), s.pending.begin(), s.pending.end());
  const int journal_error = s.journal.append(RecordType::shot, encode(facts));
  if (journal_error == 0) {
    if (facts.of_shot) ++s.saved;
    s.pending.clear();
    s.unsaved_revisions.clear();
    // A name not given now is given by finish() or recover().
    if (facts.projected) s.projected.publish(*facts.projected);
  } else {
    s.unsaved_revisions = std::move(whole.revisions);
  }
  if (entry.mosaic) {
    for (const auto& tile : entry.mosaic->tiles) s.tiles[place_of(*tile)] = tile;
  }
  std::vector<Alert> alerts = s.conclude(facts, image_error, journal_error);
  const int originals_error = s.originals.add(*entry.orientation, s.info, s.config.originals);
  std::ranges::move(s.conclude_originals(facts, originals_error), std::back_inserter(alerts));
  return alerts;
}

void Dive::add(std::span<const Alert> alerts) {
  State& s = *state_;
  const std::size_t room = kMostPending - std::min(s.pending.size(), kMostPending);
  std::ranges::copy(alerts.first(std::min(alerts.size(), room)), std::back_inserter(s.pending));
  s.record_pending();  // a disk that fails is told with the next entry
}

bool Dive::add(const Mark& mark) {
  return mark.position.allFinite() && state_->journal.append(RecordType::mark, encode(mark)) == 0;
}

bool Dive::is_paused() const { return state_->condition == Condition::paused; }
std::uint64_t Dive::seen() const { return state_->seen; }
std::uint64_t Dive::saved() const { return state_->saved; }

std::vector<Alert> Dive::finish(const nlohmann::json& rates, std::uint64_t dropped_after) {
  State& s = *state_;
  s.record_pending();
  s.journal.append(RecordType::end, encode_end(s.captured + dropped_after, dropped_after));
  s.journal.close();
  s.originals.finish();
  try {
    return s.make_files(rates);
  } catch (const InputError& error) {  // the journal is gone, perhaps with the card
    return {unfinished(error.what())};
  }
}

}  // namespace nadir::record
