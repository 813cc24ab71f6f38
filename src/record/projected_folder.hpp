// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// projected/: an image is written into one of some spare files whose names were made durable
// beforehand, so that it costs one sync. Once the journal names the spare file, it and its world
// file get their names.
#pragma once

#include "facts.hpp"
#include "nadir/image_io/encode.hpp"
#include "nadir/record/disk.hpp"

namespace nadir::record {

class ProjectedFolder {
 public:
  ProjectedFolder(Disk& disk, const path& dive) : disk_(disk), dive_(dive) {}

  /// 0 when the image is durable in a spare file, which `file` then describes; else -errno.
  int write(const ProjectedImage& image, image_io::PngEffort effort, ProjectedFile& file);
  int publish(const ProjectedFile& file);

 private:
  int make_spares();

  Disk& disk_;
  path dive_;
  std::uint64_t next_spare_ = 0, spares_end_ = 0;
};

struct Settling {
  bool thorough = false;      ///< the image's content is compared, too
  bool keep_changed = false;  ///< an auxiliary file that says something else becomes NAME.changed
};
/// Makes sure that an image the journal names has its name and its world file, as publish() would,
/// and GDAL's auxiliary file as given. False when it is neither under its own name nor in the spare
/// file.
/// With a grid, the world file is on it.
bool settle(Disk& disk, const path& dive, const ProjectedFile& file,
            const std::optional<reference::UtmGrid>& grid, std::string_view auxiliary,
            Settling how);

path world_file_name(path image_name);
path auxiliary_name(path image_name);
path spare_name(const path& dive, std::uint64_t spare);
bool is_spare(const path& name);

/// The six lines of an ESRI world file.
std::string text_of(const WorldFile& world);
/// With a grid, of the same on it.
std::string text_of(const WorldFile& survey, const std::optional<reference::UtmGrid>& grid);

}  // namespace nadir::record
