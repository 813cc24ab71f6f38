// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A file that appears whole or not at all: written under a temporary name, synced, renamed.
#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "archive.hpp"
#include "nadir/record/disk.hpp"

namespace nadir::record {

/// What identifies the content of a file.
struct Stamp {
  std::uint64_t size = 0;
  std::uint32_t crc32 = 0;
  bool operator==(const Stamp&) const = default;
  void add(ByteView bytes);
};

/// A file on disk; a stream without one when it is none: a pipe, a device or what a link leads to
/// could be waited for.
std::ifstream open_to_read(const path& file);

/// Of a file on disk; none when it cannot be read.
std::optional<Stamp> stamp_of(const path& file);

class LooseFile {
 public:
  LooseFile(Disk& disk, path name);
  ~LooseFile();
  LooseFile(const LooseFile&) = delete;
  LooseFile& operator=(const LooseFile&) = delete;

  /// False after the first failure; commit() tells it again.
  bool write(ByteView bytes);
  bool write(std::string_view text) { return write(as_bytes(text)); }
  /// Gives the file its name, replacing one that was there. The name is durable once its directory
  /// is synced; without durable the content is not either. 0 or -errno.
  int commit(bool durable = true);
  /// Leaves what had the name before untouched. -errno: why.
  int abandon();
  /// Of what was committed.
  const Stamp& stamp() const { return stamp_; }

 private:
  void flush();
  void send(ByteView bytes);
  void close();

  Disk& disk_;
  path name_, temporary_;
  int file_;
  int error_;
  Bytes buffer_;
  Stamp stamp_;
};

/// Whether the name is one a LooseFile in the making has.
bool is_temporary(const path& name);

}  // namespace nadir::record
