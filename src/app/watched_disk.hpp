// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A slow card answers call by call: each that comes back is a sign of life of the stage that waits.
#pragma once

#include "nadir/pipeline/progress.hpp"
#include "nadir/record/disk.hpp"

namespace nadir::app {

class WatchedDisk : public record::Disk {
 public:
  int open(const record::path& name, Open mode) override { return noted(Disk::open(name, mode)); }
  std::int64_t write(int file, record::ByteView bytes) override {
    return noted(Disk::write(file, bytes));
  }
  int sync(int file) override { return noted(Disk::sync(file)); }
  int sync_all(int directory) override { return noted(Disk::sync_all(directory)); }
  int close(int file) override { return noted(Disk::close(file)); }
  int rename(const record::path& from, const record::path& to) override {
    return noted(Disk::rename(from, to));
  }
  int remove(const record::path& name) override { return noted(Disk::remove(name)); }
  int make_directory(const record::path& name) override {
    return noted(Disk::make_directory(name));
  }

 private:
  template <class Result>
  static Result noted(Result result) {
    pipeline::note_progress();
    return result;
  }
};

}  // namespace nadir::app
