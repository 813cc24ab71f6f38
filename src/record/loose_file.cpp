// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "loose_file.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <cerrno>

namespace nadir::record {
namespace {

constexpr std::size_t kBuffer = 1 << 18;
constexpr std::string_view kTemporary = ".tmp";

path temporary_name(const path& name) {
  std::string hidden(1, '.');
  hidden += name.filename().string();
  hidden += kTemporary;
  return name.parent_path() / hidden;
}

}  // namespace

void Stamp::add(ByteView bytes) {
  if (bytes.empty()) return;  // may be a null pointer, which begins anew
  size += bytes.size();
  crc32 = libdeflate_crc32(crc32, bytes.data(), bytes.size());
}

std::ifstream open_to_read(const path& file) {
  std::error_code error;
  if (is_regular_file(symlink_status(file, error))) return std::ifstream(file, std::ios::binary);
  std::ifstream none;
  none.setstate(std::ios::failbit);
  return none;
}

std::optional<Stamp> stamp_of(const path& file) {
  std::ifstream in = open_to_read(file);
  if (!in) return std::nullopt;
  Stamp stamp;
  Bytes buffer(kBuffer);
  while (in) {
    in.read(reinterpret_cast<char*>(buffer.data()), static_cast<std::streamsize>(buffer.size()));
    stamp.add(ByteView(buffer).first(static_cast<std::size_t>(in.gcount())));
  }
  return in.bad() ? std::nullopt : std::optional(stamp);
}

LooseFile::LooseFile(Disk& disk, path name)
    : disk_(disk),
      name_(std::move(name)),
      temporary_(temporary_name(name_)),
      file_(open_file(disk, temporary_, Disk::Open::fresh)),
      error_(std::min(file_, 0)) {
  buffer_.reserve(kBuffer);
}

LooseFile::~LooseFile() {
  if (file_ >= 0) abandon();
}

bool LooseFile::write(ByteView bytes) {
  if (buffer_.size() + bytes.size() > kBuffer) flush();
  if (bytes.size() > kBuffer) {
    send(bytes);
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  return error_ == 0;
}

void LooseFile::flush() {
  send(buffer_);
  buffer_.clear();
}

void LooseFile::send(ByteView bytes) {
  stamp_.add(bytes);
  if (error_ == 0) error_ = write_all(disk_, file_, bytes);
}

int LooseFile::commit(bool durable) {
  flush();
  if (error_ == 0 && durable) error_ = sync_file(disk_, file_);
  close();
  if (error_ == 0) error_ = rename_file(disk_, temporary_, name_);
  if (error_ != 0) disk_.remove(temporary_);
  return error_;
}

int LooseFile::abandon() {
  close();
  disk_.remove(temporary_);
  return error_ != 0 ? error_ : -EIO;
}

void LooseFile::close() {
  if (file_ >= 0) disk_.close(file_);
  file_ = -1;
}

bool is_temporary(const path& name) {
  const std::string text = name.filename().string();
  return text.starts_with('.') && text.ends_with(kTemporary);
}

}  // namespace nadir::record
