// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The one way record writes to the file system, so that tests can record, fail and reorder it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace nadir::record {

using std::filesystem::path;
using ByteView = std::span<const std::uint8_t>;

/// The system calls as they are: results are a value >= 0, or -errno. Writes may be short.
class Disk {
 public:
  enum class Open { fresh, secret, existing, directory };

  virtual ~Disk() = default;
  /// fresh: for writing, created or emptied; secret: the same, readable by its owner only;
  /// existing: emptied, must exist; directory: for sync.
  virtual int open(const path& name, Open mode);
  virtual std::int64_t write(int file, ByteView bytes);
  /// Data and size of a file, or the names in a directory, are durable when this returns 0.
  virtual int sync(int file);
  /// The same for everything on the file system of an open directory.
  virtual int sync_all(int directory);
  virtual int close(int file);
  virtual int rename(const path& from, const path& to);
  /// A file, or a folder that is empty.
  virtual int remove(const path& name);
  virtual int make_directory(const path& name);
};

Disk& system_disk();

// What follows is made of the calls above and takes up again what was interrupted or cut short.
// Results are -errno when it failed.
int open_file(Disk& disk, const path& name, Disk::Open mode);
int rename_file(Disk& disk, const path& from, const path& to);
int write_all(Disk& disk, int file, ByteView bytes);
int sync_file(Disk& disk, int file);
int sync_directory(Disk& disk, const path& folder);
int sync_file_system(Disk& disk, const path& folder);

/// "no space left on device" and the like.
std::string_view describe(int negative_errno);

inline ByteView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Held as long as the dive is written; lets a second program see that it is.
class FolderLock {
 public:
  explicit FolderLock(const path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  bool held() const { return held_; }

 private:
  int file_;
  bool held_;
};

}  // namespace nadir::record
