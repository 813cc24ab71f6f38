// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Folders read so that no link and no name leads out of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace nadir::app {

/// An open file or folder.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

struct Item {
  std::string name;
  bool is_folder = false;
  std::uint64_t size = 0;
  std::int64_t changed_ns = 0;  ///< since 1970
};

class File {
 public:
  explicit File(std::shared_ptr<const Descriptor> file) : file_(std::move(file)) {}
  /// As pread does.
  std::ptrdiff_t read(std::uint64_t at, std::span<char> into) const;

 private:
  std::shared_ptr<const Descriptor> file_;
};

class Folder {
 public:
  /// Of that name, wherever it leads.
  static std::optional<Folder> at(const std::filesystem::path& name);

  /// In this folder: itself, no link to it. None when there is no such folder or file.
  std::optional<Folder> folder(const std::string& name) const;
  std::optional<File> file(const std::string& name) const;
  /// What it is; of files and folders only.
  std::optional<Item> item(const std::string& name) const;
  /// Its files and folders by name, but those whose names begin with a point.
  std::vector<Item> items() const;

 private:
  explicit Folder(int number) : folder_(std::make_shared<const Descriptor>(number)) {}

  std::shared_ptr<const Descriptor> folder_;
};

}  // namespace nadir::app
