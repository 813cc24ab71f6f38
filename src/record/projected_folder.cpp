// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "projected_folder.hpp"

#include <fstream>
#include <iterator>

#include "loose_file.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

constexpr std::uint64_t kSpares = 32;  // made at once; each costs an inode until it is used
constexpr std::string_view kSpare = ".spare-";

int write_and_sync(Disk& disk, const path& name, ByteView bytes) {
  const int file = open_file(disk, name, Disk::Open::existing);
  if (file < 0) return file;
  int result = write_all(disk, file, bytes);
  if (result == 0) result = sync_file(disk, file);
  disk.close(file);
  return result;
}

int write_text(Disk& disk, const path& name, std::string_view text) {
  LooseFile file(disk, name);
  file.write(text);
  return file.commit(false);
}

bool is_whole(const path& name, const ProjectedFile& file, bool thorough) {
  if (thorough) return stamp_of(name) == Stamp{file.size, file.crc32};
  std::error_code error;
  return std::filesystem::file_size(name, error) == file.size && !error;
}

bool holds(const path& name, std::string_view text) {
  std::ifstream in = open_to_read(name);
  return in && std::string((std::istreambuf_iterator<char>(in)), {}) == text;
}

}  // namespace

int ProjectedFolder::write(const ProjectedImage& image, image_io::PngEffort effort,
                           ProjectedFile& file) {
  if (next_spare_ == spares_end_) {
    if (const int error = make_spares(); error != 0) return error;
  }
  const std::uint64_t spare = next_spare_++;  // one that failed is not used again
  const Bytes png = image_io::encode_png(image.bgra, effort);
  const int error = write_and_sync(disk_, spare_name(dive_, spare), png);
  if (error != 0) {
    disk_.remove(spare_name(dive_, spare));
    return error;
  }
  Stamp stamp;
  stamp.add(png);
  file.image = image.image;
  file.spare = spare;
  file.world = image.world;
  file.size = stamp.size;
  file.crc32 = stamp.crc32;
  return 0;
}

int ProjectedFolder::publish(const ProjectedFile& file) {
  const path name = projected_name(dive_, file.image);
  const int error = write_text(disk_, world_file_name(name), text_of(file.world));
  return error != 0 ? error : rename_file(disk_, spare_name(dive_, file.spare), name);
}

int ProjectedFolder::make_spares() {
  for (std::uint64_t spare = spares_end_; spare < spares_end_ + kSpares; ++spare) {
    const int file = open_file(disk_, spare_name(dive_, spare), Disk::Open::fresh);
    if (file < 0) return file;
    disk_.close(file);
  }
  if (const int error = sync_directory(disk_, dive_ / "projected"); error != 0) return error;
  spares_end_ += kSpares;
  return 0;
}

bool settle(Disk& disk, const path& dive, const ProjectedFile& file,
            const std::optional<reference::UtmGrid>& grid, std::string_view auxiliary,
            Settling how) {
  const path name = projected_name(dive, file.image);
  const std::string world = text_of(file.world, grid);
  if (!holds(world_file_name(name), world)) write_text(disk, world_file_name(name), world);
  if (const path beside = auxiliary_name(name); !holds(beside, auxiliary)) {
    // GDAL's own programs write statistics into it.
    std::error_code error;
    if (how.keep_changed && std::filesystem::exists(beside, error))
      rename_file(disk, beside, path(beside) += ".changed");
    write_text(disk, beside, auxiliary);
  }
  if (is_whole(name, file, how.thorough)) return true;
  const path spare = spare_name(dive, file.spare);
  return is_whole(spare, file, how.thorough) && rename_file(disk, spare, name) == 0;
}

path projected_name(const path& dive, std::uint64_t image) {
  return dive / "projected" / (padded(image, 6) + ".png");
}

path world_file_name(path image_name) { return image_name.replace_extension(".pgw"); }

path auxiliary_name(path image_name) { return image_name += ".aux.xml"; }

path spare_name(const path& dive, std::uint64_t spare) {
  return dive / "projected" / (std::string(kSpare) + padded(spare, 6));
}

bool is_spare(const path& name) { return name.filename().string().starts_with(kSpare); }

std::string text_of(const WorldFile& world) {
  constexpr int kDecimals = 12;  // of a pixel a millimetre wide, after 10^6 columns: a micrometre
  std::string text;
  for (const double value : {world.a, world.d, world.b, world.e, world.c, world.f}) {
    text += fixed(value, kDecimals) + '\n';
  }
  return text;
}

std::string text_of(const WorldFile& survey, const std::optional<reference::UtmGrid>& grid) {
  return text_of(grid ? (*grid)(survey) : survey);
}

}  // namespace nadir::record
