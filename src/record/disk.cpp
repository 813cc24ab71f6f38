// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/record/disk.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace nadir::record {
namespace {

int flags(Disk::Open mode) {
  switch (mode) {
    case Disk::Open::fresh:
    case Disk::Open::secret:
      return O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
    case Disk::Open::existing:
      return O_WRONLY | O_TRUNC | O_CLOEXEC;
    case Disk::Open::directory:
      return O_RDONLY | O_DIRECTORY | O_CLOEXEC;
  }
  return O_RDONLY;
}

int or_errno(int result) { return result < 0 ? -errno : result; }

template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result == -EINTR) result = call();
  return result;
}

}  // namespace

int Disk::open(const path& name, Open mode) {
  constexpr mode_t kReadableByAll = 0644, kReadableByOwner = 0600;
  return or_errno(
      ::open(name.c_str(), flags(mode), mode == Open::secret ? kReadableByOwner : kReadableByAll));
}

std::int64_t Disk::write(int file, ByteView bytes) {
  const ssize_t written = ::write(file, bytes.data(), bytes.size());
  return written < 0 ? -errno : written;
}

int Disk::sync(int file) { return or_errno(::fdatasync(file)); }
int Disk::sync_all(int directory) { return or_errno(::syncfs(directory)); }
int Disk::close(int file) { return or_errno(::close(file)); }

int Disk::rename(const path& from, const path& to) {
  return or_errno(::rename(from.c_str(), to.c_str()));
}

int Disk::remove(const path& name) { return or_errno(::remove(name.c_str())); }

int Disk::make_directory(const path& name) {
  constexpr mode_t kSearchableByAll = 0755;
  return or_errno(::mkdir(name.c_str(), kSearchableByAll));
}

Disk& system_disk() {
  static Disk disk;
  return disk;
}

int open_file(Disk& disk, const path& name, Disk::Open mode) {
  return uninterrupted([&] { return disk.open(name, mode); });
}

int rename_file(Disk& disk, const path& from, const path& to) {
  return uninterrupted([&] { return disk.rename(from, to); });
}

int write_all(Disk& disk, int file, ByteView bytes) {
  while (!bytes.empty()) {
    const std::int64_t written = uninterrupted([&] { return disk.write(file, bytes); });
    if (written < 0) return static_cast<int>(written);
    if (written == 0) return -ENOSPC;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

int sync_file(Disk& disk, int file) {
  return uninterrupted([&] { return disk.sync(file); });
}

int sync_directory(Disk& disk, const path& folder) {
  const int file = open_file(disk, folder, Disk::Open::directory);
  if (file < 0) return file;
  const int result = sync_file(disk, file);
  disk.close(file);
  return result;
}

int sync_file_system(Disk& disk, const path& folder) {
  const int file = open_file(disk, folder, Disk::Open::directory);
  if (file < 0) return file;
  const int result = uninterrupted([&] { return disk.sync_all(file); });
  disk.close(file);
  return result;
}

std::string_view describe(int negative_errno) {
  const char* text = ::strerrordesc_np(-negative_errno);
  return text ? text : "unknown error";
}

FolderLock::FolderLock(const path& folder)
    : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)),
      held_(file_ >= 0 && ::flock(file_, LOCK_EX | LOCK_NB) == 0) {}

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace nadir::record
