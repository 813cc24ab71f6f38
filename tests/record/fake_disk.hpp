// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Disks that remember, fail, and forget what was not synced.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "nadir/record/disk.hpp"

namespace nadir::record {

/// A real disk without the wait for the medium.
class QuickDisk : public Disk {
 public:
  int sync(int) override { return 0; }
  int sync_all(int) override { return 0; }
};

/// One thing that was asked of the disk, as far as it matters after a power cut.
struct Operation {
  enum Kind { create, write, truncate, rename, remove, folder, sync_file, sync_folder, sync_all };
  Kind kind{};
  std::string name;   ///< the file or folder
  std::string other;  ///< rename: the new name; write: the bytes
  int inode = -1;
  std::size_t offset = 0;
};

/// Does everything, and writes down what was done.
class RecordingDisk : public QuickDisk {
 public:
  int open(const path& name, Open mode) override {
    const bool there = inodes_.contains(name.string());
    const int file = QuickDisk::open(name, mode);
    if (file < 0) return file;
    if (mode == Open::directory) {
      files_[file] = {name.string(), -1, 0};
      return file;
    }
    if (!there) {
      inodes_[name.string()] = next_inode_++;
      operations.push_back({Operation::create, name.string(), {}, inodes_[name.string()], 0});
    } else {
      operations.push_back({Operation::truncate, name.string(), {}, inodes_[name.string()], 0});
    }
    files_[file] = {name.string(), inodes_[name.string()], 0};
    return file;
  }
  std::int64_t write(int file, ByteView bytes) override {
    const std::int64_t written = QuickDisk::write(file, bytes);
    File& f = files_[file];
    operations.push_back(
        {Operation::write, f.name, std::string(bytes.begin(), bytes.end()), f.inode, f.size});
    f.size += bytes.size();
    return written;
  }
  int sync(int file) override {
    const File& f = files_[file];
    operations.push_back(
        {f.inode < 0 ? Operation::sync_folder : Operation::sync_file, f.name, {}, f.inode, 0});
    return 0;
  }
  int sync_all(int) override {
    operations.push_back({Operation::sync_all, {}, {}, -1, 0});
    return 0;
  }
  int close(int file) override {
    files_.erase(file);
    return QuickDisk::close(file);
  }
  int rename(const path& from, const path& to) override {
    const int result = QuickDisk::rename(from, to);
    if (result == 0) {
      inodes_[to.string()] = inodes_[from.string()];
      inodes_.erase(from.string());
      operations.push_back({Operation::rename, from.string(), to.string(), -1, 0});
    }
    return result;
  }
  int remove(const path& name) override {
    const int result = QuickDisk::remove(name);
    if (result == 0) {
      inodes_.erase(name.string());
      operations.push_back({Operation::remove, name.string(), {}, -1, 0});
    }
    return result;
  }
  int make_directory(const path& name) override {
    const int result = QuickDisk::make_directory(name);
    if (result == 0) operations.push_back({Operation::folder, name.string(), {}, -1, 0});
    return result;
  }
  /// A file that was there before this disk was used.
  void know(const path& name) { inodes_[name.string()] = next_inode_++; }
  int inode(const path& name) const { return inodes_.at(name.string()); }

  std::vector<Operation> operations;

 private:
  struct File {
    std::string name;
    int inode = -1;
    std::size_t size = 0;
  };
  std::map<int, File> files_;
  std::map<std::string, int> inodes_;
  int next_inode_ = 0;
};

/// Asks before each call whether it is to fail. After a sync that failed, what was written since
/// the last good one is gone, as Linux may have it.
class FailingDisk : public QuickDisk {
 public:
  enum class Call { open, write, sync, close, rename, remove, folder };
  /// 0: go on; -errno: fail; kShort: write half.
  static constexpr int kShort = 1;
  std::function<int(Call)> verdict = [](Call) { return 0; };

  int open(const path& name, Open mode) override {
    if (const int bad = verdict(Call::open); bad < 0) return bad;
    const int file = QuickDisk::open(name, mode);
    if (file >= 0 && mode != Open::directory) sizes_[file] = {0, 0};
    return file;
  }
  std::int64_t write(int file, ByteView bytes) override {
    const int bad = verdict(Call::write);
    if (bad == -EINTR) return bad;
    const bool partly = bad != 0 && bytes.size() > 1;
    const std::size_t size = partly ? bytes.size() / 2 : bytes.size();
    if (bad < 0 && !(bad == -ENOSPC && partly)) return bad;
    const std::int64_t written = QuickDisk::write(file, bytes.first(size));
    sizes_[file].first += size;
    return written;
  }
  int sync(int file) override {
    const int bad = verdict(Call::sync);
    const auto sizes = sizes_.find(file);
    if (sizes == sizes_.end()) return std::min(bad, 0);
    if (bad >= 0) {
      sizes->second.second = sizes->second.first;
      return 0;
    }
    if (bad != -EINTR && ::ftruncate(file, static_cast<off_t>(sizes->second.second)) != 0) {
      return -EBADF;
    }
    return bad;
  }
  int sync_all(int) override { return std::min(verdict(Call::sync), 0); }
  int close(int file) override {
    const int bad = verdict(Call::close);
    sizes_.erase(file);
    QuickDisk::close(file);
    return std::min(bad, 0);
  }
  int rename(const path& from, const path& to) override {
    const int bad = verdict(Call::rename);
    return bad < 0 ? bad : QuickDisk::rename(from, to);
  }
  int remove(const path& name) override {
    const int bad = verdict(Call::remove);
    return bad < 0 ? bad : QuickDisk::remove(name);
  }
  int make_directory(const path& name) override {
    const int bad = verdict(Call::folder);
    return bad < 0 ? bad : QuickDisk::make_directory(name);
  }

 private:
  std::map<int, std::pair<std::size_t, std::size_t>> sizes_;  ///< written, durable
};

}  // namespace nadir::record
