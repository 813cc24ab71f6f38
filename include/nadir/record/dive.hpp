// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A dive on disk while it is recorded (paper 3.4.1, 3.5). The journal is the commit: what add()
// has recorded survives a power cut at any instant and recover() makes every other file from it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "nadir/core/cloud.hpp"
#include "nadir/core/mark.hpp"
#include "nadir/core/revision.hpp"
#include "nadir/core/tile.hpp"
#include "nadir/reference/geodetic.hpp"

namespace nadir::record {

class Disk;

/// Which images of live cameras are kept as they came, beside the projected ones.
enum class Originals { none, key_frames, all };

struct Config {
  std::string dives = "/var/lib/nadir/dives";  ///< of the service, a folder each

  Originals originals = Originals::none;  ///< in DIVE/survey, which can be replayed
  bool projected = true;   ///< save each projected image; without them mosaics cannot be recovered
  bool small_png = false;  ///< smaller projected images for a little more time

  /// Throws InputError when dives is empty.
  void check() const;
};

/// What is known when the dive begins.
struct DiveInfo {
  /// Members of dive.json as they are: input, configuration, versions.
  nlohmann::json about = nlohmann::json::object();
  /// Copied into the survey folder of the originals: names and contents.
  std::vector<std::pair<std::string, std::string>> survey_files{};
  /// Of the survey. Where the survey is in metres and its axes are by attitude, the files for GIS
  /// are on the UTM grid around it; y is then the grid's north.
  std::optional<reference::Geodetic> origin{};
};

/// All that was made of one shot, or (an orientation without a shot) after the last; any of
/// surface, cloud and mosaic may be null (dropped on a live edge).
struct Entry {
  std::shared_ptr<const Orientation> orientation;
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const Cloud> cloud;
  std::shared_ptr<const MosaicUpdate> mosaic;
  std::vector<std::shared_ptr<const Revision>> revisions{};  ///< that came meanwhile
};

/// Used by one thread. Blocks on the disk only; after the constructor, a disk that fails is told by
/// alerts, which are recorded too as soon as that is possible. While the disk is full recording
/// pauses; it goes on by itself, and images not recorded are counted as dropped by "storage".
class Dive {
 public:
  /// Makes the folder where needed. Throws InputError when it is not empty or cannot be written;
  /// what was made is then taken away again as far as the disk lets it.
  Dive(const std::filesystem::path& folder, const DiveInfo& info, const Config& config);
  Dive(const std::filesystem::path& folder, const DiveInfo& info, const Config& config, Disk& disk);
  ~Dive();
  Dive(const Dive&) = delete;
  Dive& operator=(const Dive&) = delete;

  /// Records one shot; shots come in order. One sync, and one more when there is a projected image.
  [[nodiscard]] std::vector<Alert> add(const Entry& entry);
  /// Records an alert that belongs to no entry, at the latest with the next one that is recorded.
  void add(const Alert& alert) { add(std::span(&alert, 1)); }
  /// The same of several, with one sync.
  void add(std::span<const Alert> alerts);

  /// Whether the mark, or its removal, is durable; else it is not recorded. What is not finite is
  /// not.
  [[nodiscard]] bool add(const Mark& mark);

  /// Whether the disk took nothing of the last entry.
  bool is_paused() const;
  /// Entries given, and entries that are durable.
  std::uint64_t seen() const;
  std::uint64_t saved() const;

  /// Makes the loose files from what was recorded, dive.json last: a dive that has one is complete.
  /// rates go into it as they are; dropped_after: images that a full queue dropped after the last
  /// entry. Nothing may be added later. Empty when every file was written; else recover() will do.
  [[nodiscard]] std::vector<Alert> finish(const nlohmann::json& rates,
                                          std::uint64_t dropped_after = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Where a dive keeps an image projected onto the ground, once it was.
std::filesystem::path projected_name(const std::filesystem::path& dive, std::uint64_t image);

}  // namespace nadir::record
