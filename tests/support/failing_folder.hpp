// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A folder that cannot be read to its end, as a power cut may leave one. To be included by a test's
// one source: it takes the place of the C library's readdir(3).
#pragma once

#include <dirent.h>
#include <dlfcn.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>

namespace nadir::support {

/// As long as it lives, reading fails behind the first entry. The folder needs two, at least.
class FailingFolder {
 public:
  explicit FailingFolder(const std::filesystem::path& folder) { ::stat(folder.c_str(), &status()); }
  ~FailingFolder() { status() = {}; }
  FailingFolder(const FailingFolder&) = delete;
  FailingFolder& operator=(const FailingFolder&) = delete;

  static bool is(DIR* folder) {
    struct stat other {};
    return status().st_ino != 0 && ::fstat(::dirfd(folder), &other) == 0 &&
           other.st_dev == status().st_dev && other.st_ino == status().st_ino;
  }

 private:
  static struct stat& status() {
    static struct stat failing {};
    return failing;
  }
};

}  // namespace nadir::support

extern "C" dirent* readdir(DIR* folder) {
  using Readdir = dirent* (*)(DIR*);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as dlsym(3) has it
  static const auto read = reinterpret_cast<Readdir>(::dlsym(RTLD_NEXT, "readdir"));
  static DIR* begun = nullptr;  // has given an entry
  const bool fails = nadir::support::FailingFolder::is(folder);
  if (fails && folder == begun) {
    begun = nullptr;
    errno = EIO;
    return nullptr;
  }
  dirent* const entry = read(folder);
  if (fails && entry != nullptr && entry->d_name[0] != '.') begun = folder;
  return entry;
}
