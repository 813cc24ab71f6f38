// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "dives.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <tuple>
#include <utility>

#include "nadir/record/dive.hpp"
#include "opaque_id.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kRemoved = ".removed-";
constexpr std::string_view kMosaics = "mosaic2d";
constexpr std::size_t kMostFiles = 1'000'000, kMostDepth = 4;
constexpr std::uint64_t kMostSummary = 64u << 20;

bool is_dive(const Folder& folder) {
  return folder.item("dive.json") || folder.item("journal-000.nadir");
}

void walk(const Folder& folder, const std::vector<std::string>& way,
          std::vector<TarMember>& members) {
  for (Item& item : folder.items()) {
    if (members.size() >= kMostFiles) return;
    std::vector<std::string> to = way;
    to.push_back(item.name);
    if (!item.is_folder) {
      members.push_back({std::move(to), std::move(item)});
    } else if (const auto inner = folder.folder(item.name); inner && to.size() < kMostDepth) {
      walk(*inner, to, members);
    }
  }
}

std::vector<TarMember> members_of(const Folder& folder) {
  std::vector<TarMember> members;
  walk(folder, {}, members);
  return members;
}

std::uint64_t bytes_of(const std::vector<TarMember>& members) {
  std::uint64_t bytes = 0;
  for (const TarMember& member : members) bytes += member.item.size;
  return bytes;
}

std::string id_of(const std::vector<std::string>& way) {
  std::string path;
  for (const std::string& step : way) path += '/' + step;
  return opaque_id(path);
}

json summary_of(const Folder& folder) {
  const auto item = folder.item("dive.json");
  const auto file = folder.file("dive.json");
  if (!item || !file || item->size > kMostSummary) return json();
  std::string text(item->size, '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const std::ptrdiff_t size = file->read(filled, std::span(text).subspan(filled));
    if (size <= 0) return json();
    filled += static_cast<std::size_t>(size);
  }
  return json::parse(text, nullptr, false);
}

/// A count or an area; null for whatever else a damaged file says.
json amount_at(const json& object, const json::json_pointer& pointer) {
  constexpr double kMost = 1e15;
  if (!object.is_object() || !object.contains(pointer)) return json();
  const json& value = object.at(pointer);
  if (!value.is_number()) return json();
  const auto amount = value.get<double>();
  return amount >= 0 && amount <= kMost ? value : json();
}

bool are_digits(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// In the name when the clock was set: "dive-0042-20261129-190402".
json begun_of(const std::string& name) {
  constexpr std::size_t kLength = 16;
  if (name.size() < kLength) return json();
  const std::string time = name.substr(name.size() - kLength);
  const auto is_at_most = [&](std::size_t at, const char* most) {
    return time.compare(at, 2, most) <= 0;
  };
  const bool is_time = time[0] == '-' && time[9] == '-' && are_digits(time.substr(1, 8)) &&
                       are_digits(time.substr(10)) && is_at_most(5, "12") && is_at_most(7, "31") &&
                       is_at_most(10, "23") && is_at_most(12, "59") && is_at_most(14, "60");
  if (!is_time) return json();
  return time.substr(1, 4) + '-' + time.substr(5, 2) + '-' + time.substr(7, 2) + 'T' +
         time.substr(10, 2) + ':' + time.substr(12, 2) + ':' + time.substr(14, 2) + 'Z';
}

// Dives are numbered; folders that have other names go by when they were begun or copied.
std::tuple<std::uint32_t, std::int64_t> age_of(const std::string& name, const Folder& folder) {
  constexpr std::string_view kBegin = "dive-";
  std::uint32_t number = 0;
  if (name.starts_with(kBegin)) {
    std::from_chars(name.data() + kBegin.size(), name.data() + name.size(), number);
  }
  const auto journal = folder.item("journal-000.nadir");
  return {number, journal ? journal->changed_ns : 0};
}

std::string kind_of(const std::string& folder, const std::string& name) {
  if (name.ends_with(".pgw") || name.ends_with(".aux.xml")) return "place";
  if (folder == kMosaics && name.ends_with(".png")) return "mosaic";
  if (folder == "projected") return "projected";
  if (name == "dive.json") return "summary";
  if (name.ends_with(".ply")) return "points";
  if (name.ends_with(".tum") || name == "track.csv") return "trajectory";
  if (name == "health.csv") return "health";
  if (name == "alerts.jsonl") return "alerts";
  if (name.starts_with("marks.")) return "marks";
  if (name.starts_with("journal-")) return "journal";
  return folder == "survey" ? "original" : "other";
}

void add_products(const Folder& folder, const std::string& name, json& products) {
  for (const Item& item : folder.items()) {
    if (item.is_folder) continue;
    const std::vector<std::string> way =
        name.empty() ? std::vector{item.name} : std::vector{name, item.name};
    products.push_back({{"id", id_of(way)},
                        {"name", item.name},
                        {"bytes", item.size},
                        {"kind", kind_of(name, item.name)}});
  }
}

}  // namespace

std::optional<serve::Download> download_of(const Folder& folder, const std::string& name) {
  const auto item = folder.item(name);
  const auto file = item ? folder.file(name) : std::nullopt;
  if (!file) return std::nullopt;
  return serve::Download{
      name, item->size, std::to_string(item->size) + '-' + std::to_string(item->changed_ns),
      [file = *file](std::uint64_t from, std::span<char> into) { return file.read(from, into); }};
}

Dives::Dives(const fs::path& folder, const LiveDive& live, record::Disk& disk)
    : folder_(fs::absolute(folder).lexically_normal()),
      live_(live),
      disk_(disk),
      sweeper_(folder_, std::string(kRemoved)) {}

json Dives::entry_of(const std::string& name, const Folder& folder) {
  const auto summary_item = folder.item("dive.json");
  const auto known = known_.find(name);
  if (summary_item && known != known_.end() &&
      known->second.changed_ns == summary_item->changed_ns) {
    return known->second.entry;
  }
  const json summary = summary_of(folder);
  json entry{{"id", opaque_id(name)},
             {"name", name},
             {"begun", begun_of(name)},
             {"images", amount_at(summary, json::json_pointer("/counts/captured"))},
             {"area_m2", amount_at(summary, json::json_pointer("/area_m2"))},
             {"bytes", bytes_of(members_of(folder))},
             {"complete", summary_item.has_value()},
             {"recording", false}};
  if (summary_item) known_[name] = {summary_item->changed_ns, entry};
  return entry;
}

bool Dives::is_live(const std::string& name) const {
  const LiveDive::Now live = live_.now();
  return live.is_recording && live.folder == folder_ / name;
}

json Dives::list() {
  sweeper_.sweep();
  using Aged = std::pair<std::tuple<std::uint32_t, std::int64_t>, json>;
  std::vector<Aged> dives;
  const auto all = Folder::at(folder_);
  for (const Item& item : all ? all->items() : std::vector<Item>()) {
    const auto folder = item.is_folder ? all->folder(item.name) : std::nullopt;
    if (!folder || !is_dive(*folder)) continue;
    json entry = entry_of(item.name, *folder);
    if (is_live(item.name)) {
      entry["recording"] = true;
      entry["images"] = live_.now().saved;
    }
    dives.emplace_back(age_of(item.name, *folder), std::move(entry));
  }
  std::ranges::stable_sort(dives, std::greater(), &Aged::first);
  json list = json::array();
  for (auto& [age, entry] : dives) list.push_back(std::move(entry));
  return list;
}

std::optional<Dives::Found> Dives::find(const std::string& dive) const {
  const auto all = Folder::at(folder_);
  if (!all) return std::nullopt;
  for (const Item& item : all->items()) {
    if (!item.is_folder || opaque_id(item.name) != dive) continue;
    auto folder = all->folder(item.name);
    if (folder && is_dive(*folder)) return Found{item.name, *std::move(folder)};
  }
  return std::nullopt;
}

std::optional<json> Dives::products(const std::string& dive, const std::string& folder) {
  const auto found = find(dive);
  if (!found) return std::nullopt;
  json products = json::array(), folders = json::array();
  if (!folder.empty()) {
    const auto inner = found->folder.folder(folder);
    if (!inner) return std::nullopt;
    add_products(*inner, folder, products);
  } else {
    add_products(found->folder, "", products);
    for (const Item& item : found->folder.items()) {
      const auto inner = item.is_folder ? found->folder.folder(item.name) : std::nullopt;
      if (!inner) continue;
      if (item.name == kMosaics) add_products(*inner, item.name, products);
      const std::vector<TarMember> members = members_of(*inner);
      folders.push_back(
          {{"name", item.name}, {"files", members.size()}, {"bytes", bytes_of(members)}});
    }
  }
  return json{{"id", dive}, {"name", found->name}, {"products", products}, {"folders", folders}};
}

std::optional<serve::Download> Dives::file(const std::string& dive, const std::string& file) {
  const auto found = find(dive);
  if (!found) return std::nullopt;
  if (table_.dive != dive || !table_.way_of_id.contains(file)) {
    table_ = {dive, {}};
    for (TarMember& member : members_of(found->folder)) {
      const std::string id = id_of(member.way);
      table_.way_of_id[id] = std::move(member.way);
    }
  }
  const auto entry = table_.way_of_id.find(file);
  if (entry == table_.way_of_id.end()) return std::nullopt;
  const std::vector<std::string>& way = entry->second;
  std::optional<Folder> folder = found->folder;
  for (std::size_t i = 0; folder && i + 1 < way.size(); ++i) folder = folder->folder(way[i]);
  return folder ? download_of(*folder, way.back()) : std::nullopt;
}

std::optional<serve::Download> Dives::projected(const std::string& dive, std::uint64_t image) {
  const auto found = find(dive);
  const fs::path way = record::projected_name({}, image);
  const auto folder = found ? found->folder.folder(way.parent_path()) : std::nullopt;
  return folder ? download_of(*folder, way.filename()) : std::nullopt;
}

std::optional<serve::Download> Dives::archive(const std::string& dive) {
  const auto found = find(dive);
  if (!found) return std::nullopt;
  constexpr std::size_t kMostName = 60;  // of what ustar has room for
  const std::string name = found->name.substr(0, kMostName);
  const auto tar = std::make_shared<Tar>(found->folder, name, members_of(found->folder));
  return serve::Download{
      name + ".tar", tar->size(), tar->tag(),
      [tar](std::uint64_t from, std::span<char> into) { return tar->read(from, into); }};
}

std::optional<fs::path> Dives::recorded(const std::string& dive) const {
  const auto found = find(dive);
  return found && !is_live(found->name) ? std::optional(folder_ / found->name) : std::nullopt;
}

Dives::Removal Dives::remove(const std::string& dive) {
  const auto found = find(dive);
  if (!found) return Removal::unknown;
  const fs::path name = folder_ / found->name;
  if (is_live(found->name)) return Removal::in_use;
  const record::FolderLock lock(name);
  if (!lock.held()) return Removal::in_use;  // by a recovery, or another program
  // Another of that name may still be on its way out.
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  const fs::path removed =
      folder_ / (std::string(kRemoved) + std::to_string(now) + '-' + found->name);
  if (record::rename_file(disk_, name, removed) < 0) return Removal::failed;
  if (record::sync_directory(disk_, folder_) < 0) return Removal::failed;
  known_.erase(found->name);
  sweeper_.sweep();
  return Removal::done;
}

}  // namespace nadir::app
