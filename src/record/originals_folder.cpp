// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "originals_folder.hpp"

#include <algorithm>
#include <fstream>
#include <numbers>
#include <system_error>

#include "loose_file.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

namespace fs = std::filesystem;

constexpr Time kSyncPeriod = 5'000'000'000;

struct Table {
  std::string_view file, header;
};
enum : std::size_t { kTimes, kAttitude, kDepth, kAltitude };
constexpr std::array<Table, 4> kTables{Table{"timestamps.csv", "frame,seconds\n"},
                                       {"ahrs.csv", "seconds,roll,pitch,yaw\n"},
                                       {"depth.csv", "seconds,depth\n"},
                                       {"altitude.csv", "seconds,altitude\n"}};

// Images between key frames show little that those do not; without a pose any may be needed.
bool is_wanted(const Orientation& orientation, Originals which) {
  if (which == Originals::none || !orientation.shot || !orientation.shot->originals) return false;
  const auto own = std::ranges::find(orientation.poses, orientation.shot->image, &ImagePose::image);
  return which == Originals::all || own == orientation.poses.end() || own->key_frame;
}

int write_file(Disk& disk, const path& name, ByteView bytes) {
  LooseFile file(disk, name);
  file.write(bytes);
  return file.commit(false);
}

int make_directory(Disk& disk, const path& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) ? 0 : disk.make_directory(folder);
}

}  // namespace

OriginalsFolder::~OriginalsFolder() {
  for (const int table : tables_) {
    if (table >= 0) disk_.close(table);
  }
}

int OriginalsFolder::begin(const Shot& shot, const DiveInfo& info) {
  if (info.origin) convergence_ = reference::UtmGrid(*info.origin).convergence();
  const bool pair = !shot.originals->right.empty();
  for (const path& folder : {folder_, folder_ / "images"}) {
    if (const int error = make_directory(disk_, folder); error < 0) return error;
  }
  for (const char* side : {"left", "right"}) {
    const int error = pair ? make_directory(disk_, folder_ / "images" / side) : 0;
    if (error < 0) return error;
  }
  for (const auto& [name, text] : info.survey_files) {
    if (const int error = write_file(disk_, folder_ / name, as_bytes(text)); error < 0)
      return error;
  }
  return append(kTimes, "");
}

// A table begins with its first row: one without any would be a sensor that is silent.
int OriginalsFolder::append(std::size_t table, const std::string& row) {
  int& file = tables_.at(table);
  std::string text = row;
  if (file < 0) {
    file = open_file(disk_, folder_ / kTables.at(table).file, Disk::Open::fresh);
    text = std::string(kTables.at(table).header) + row;
  }
  return file < 0 ? file : write_all(disk_, file, as_bytes(text));
}

int OriginalsFolder::add_rows(const Shot& shot) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const std::string time = seconds_text(shot.time);
  int error = append(kTimes, shot.name + ',' + time + '\n');
  if (!shot.frame) return error;
  const Frame& frame = *shot.frame;
  if (error == 0 && frame.attitude) {
    error = append(kAttitude, time + ',' + fixed(kDegrees * frame.attitude->roll, 4) + ',' +
                                  fixed(kDegrees * frame.attitude->pitch, 4) + ',' +
                                  fixed(kDegrees * (frame.attitude->yaw + convergence_), 4) + '\n');
  }
  if (error == 0 && frame.depth) error = append(kDepth, time + ',' + fixed(*frame.depth, 4) + '\n');
  if (error == 0 && frame.altitude)
    error = append(kAltitude, time + ',' + fixed(*frame.altitude, 4) + '\n');
  return error;
}

int OriginalsFolder::add(const Orientation& orientation, const DiveInfo& info, Originals which) {
  if (!is_wanted(orientation, which)) return 0;
  const Shot& shot = *orientation.shot;
  if (!begun_) {
    if (const int error = begin(shot, info); error < 0) return error;
    begun_ = true;
  }
  const path images = folder_ / "images", name = shot.name + ".jpg";
  const bool pair = !shot.originals->right.empty();
  int error = write_file(disk_, (pair ? images / "left" : images) / name, shot.originals->left);
  if (error == 0 && pair) error = write_file(disk_, images / "right" / name, shot.originals->right);
  if (error == 0) error = add_rows(shot);
  if (error < 0) return error;
  if (synced_ && shot.time - *synced_ < kSyncPeriod) return 0;
  synced_ = shot.time;
  return sync_file_system(disk_, folder_);
}

int OriginalsFolder::finish() { return begun_ ? sync_file_system(disk_, folder_) : 0; }

void mend_originals(Disk& disk, const path& dive) {
  std::error_code error;
  std::vector<path> unfinished;
  for (auto entry = fs::recursive_directory_iterator(dive / "survey", error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (is_temporary(entry->path())) unfinished.push_back(entry->path());
  }
  for (const path& name : unfinished) disk.remove(name);
  for (const Table& table : kTables) {
    const path name = dive / "survey" / table.file;
    std::ifstream in = open_to_read(name);
    if (!in) continue;
    const std::string text(std::istreambuf_iterator<char>(in), {});
    const std::size_t end = text.rfind('\n');
    const std::size_t whole = end == text.npos ? 0 : end + 1;
    if (whole < text.size()) fs::resize_file(name, whole, error);
  }
}

}  // namespace nadir::record
