// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace nadir::app {
namespace {

constexpr int kFolder = O_RDONLY | O_DIRECTORY | O_CLOEXEC;

// One step at a time and never through a link: a name with a slash or of two points is none.
bool is_step(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
         name.find('\0') == std::string::npos;
}

}  // namespace

Descriptor::~Descriptor() { ::close(number_); }

std::ptrdiff_t File::read(std::uint64_t at, std::span<char> into) const {
  ssize_t size;
  do {
    size = ::pread(file_->number(), into.data(), into.size(), static_cast<off_t>(at));
  } while (size < 0 && errno == EINTR);
  return size;
}

std::optional<Folder> Folder::at(const std::filesystem::path& name) {
  const int number = ::open(name.c_str(), kFolder);
  return number < 0 ? std::nullopt : std::optional(Folder(number));
}

std::optional<Folder> Folder::folder(const std::string& name) const {
  if (!is_step(name)) return std::nullopt;
  const int number = ::openat(folder_->number(), name.c_str(), kFolder | O_NOFOLLOW);
  return number < 0 ? std::nullopt : std::optional(Folder(number));
}

std::optional<File> Folder::file(const std::string& name) const {
  if (!is_step(name)) return std::nullopt;
  const int number =
      ::openat(folder_->number(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (number < 0) return std::nullopt;
  File file(std::make_shared<const Descriptor>(number));
  struct stat status {};
  const bool regular = ::fstat(number, &status) == 0 && S_ISREG(status.st_mode);
  return regular ? std::optional(std::move(file)) : std::nullopt;
}

std::optional<Item> Folder::item(const std::string& name) const {
  struct stat status {};
  if (!is_step(name) ||
      ::fstatat(folder_->number(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0 ||
      (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))) {
    return std::nullopt;
  }
  constexpr std::int64_t kSecond = 1'000'000'000;
  return Item{name, S_ISDIR(status.st_mode), static_cast<std::uint64_t>(status.st_size),
              status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec};
}

std::vector<Item> Folder::items() const {
  std::vector<Item> items;
  DIR* const open = ::fdopendir(::openat(folder_->number(), ".", kFolder));
  if (open == nullptr) return items;
  while (const dirent* entry = ::readdir(open)) {  // NOLINT(concurrency-mt-unsafe): our own
    const std::string name = entry->d_name;
    if (name.starts_with('.')) continue;
    if (auto found = item(name)) items.push_back(*std::move(found));
  }
  ::closedir(open);
  std::ranges::sort(items, {}, &Item::name);
  return items;
}

}  // namespace nadir::app
