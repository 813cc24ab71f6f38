// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A folder as one uncompressed tar file that is never written: any part of it can be read, so that
// a download can be resumed. POSIX.1-1988 ustar; sizes from 8 GiB on as GNU tar has them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "folder.hpp"

namespace nadir::app {

/// A file in it, as it was when the archive was laid out.
struct TarMember {
  std::vector<std::string> way;  ///< folders, then the file
  Item item;
};

class Tar {
 public:
  /// Of these members of `folder`, below a folder called `name` in the archive. A member whose name
  /// ustar has no room for is left out.
  Tar(Folder folder, const std::string& name, std::vector<TarMember> members);

  std::uint64_t size() const { return size_; }
  /// Another when any member is.
  std::string tag() const;
  /// As pread does; less than 0 also when a member is not as long as it was. By one thread.
  std::ptrdiff_t read(std::uint64_t at, std::span<char> into);

 private:
  struct Place {
    std::uint64_t begin = 0;  ///< of the header
    TarMember member;
    std::string name;
  };
  std::ptrdiff_t read_piece(std::uint64_t at, std::span<char> into);
  std::ptrdiff_t read_in(const Place& place, std::uint64_t at, std::span<char> into);
  const File* open(const Place& place);

  Folder folder_;
  std::vector<Place> places_;
  std::uint64_t size_ = 0;
  std::optional<File> file_;  ///< read last
  std::uint64_t file_begin_ = 0;
};

}  // namespace nadir::app
