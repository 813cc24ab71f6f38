// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "journal.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <utility>

#include "loose_file.hpp"
#include "nadir/core/check.hpp"
#include "text.hpp"

namespace nadir::record {
namespace {

constexpr std::array<char, 8> kSegmentMagic{'N', 'A', 'D', 'I', 'R', 'J', 'N', 'L'};
constexpr std::uint32_t kVersion = 7;
constexpr std::size_t kSegmentHead = 24, kSegmentHeader = 28;  // without and with its checksum
constexpr std::array<char, 4> kRecordMagic{'N', 'D', 'R', 'C'};
constexpr std::size_t kRecordHeader = 24;
constexpr std::uint32_t kLargestPayload = 1u << 28;

path segment_name(const path& folder, std::uint32_t number) {
  return folder / ("journal-" + padded(number, 3) + ".nadir");
}

Bytes segment_header(std::uint32_t number, std::uint64_t first_sequence) {
  Encoder header;
  header.raw(kSegmentMagic.data(), kSegmentMagic.size());
  header(kVersion, number, first_sequence);
  Bytes bytes = header.take();
  Encoder sum;
  sum(libdeflate_crc32(0, bytes.data(), bytes.size()));
  const Bytes checksum = sum.take();
  bytes.insert(bytes.end(), checksum.begin(), checksum.end());
  return bytes;
}

std::uint32_t checksum(std::uint32_t size, RecordType type, std::uint64_t sequence,
                       ByteView payload) {
  Encoder covered;
  covered(size, type, sequence);
  const Bytes head = covered.take();
  const std::uint32_t crc = libdeflate_crc32(0, head.data(), head.size());
  // A null pointer, which an empty payload may have, begins anew.
  return payload.empty() ? crc : libdeflate_crc32(crc, payload.data(), payload.size());
}

void frame(Encoder& records, RecordType type, std::uint64_t sequence, ByteView payload) {
  NADIR_CHECK(payload.size() <= kLargestPayload, payload.size());
  const auto size = static_cast<std::uint32_t>(payload.size());
  records.raw(kRecordMagic.data(), kRecordMagic.size());
  records(size, type, checksum(size, type, sequence, payload), sequence);
  records.raw(payload.data(), payload.size());
}

}  // namespace

int JournalWriter::append(RecordType type, std::span<const ByteView> payloads) {
  Encoder framed;
  std::uint64_t sequence = next_sequence_;
  for (const ByteView payload : payloads) frame(framed, type, sequence++, payload);
  const Bytes records = framed.take();
  int result = append_once(records);
  if (result != 0) result = append_once(records);
  next_sequence_ = sequence;  // also after a failure: the disk may hold the records all the same
  return result;
}

int JournalWriter::append_once(ByteView records) {
  int result = file_ < 0 ? begin_segment() : 0;
  if (result == 0) result = write_all(disk_, file_, records);
  if (result == 0) result = sync_file(disk_, file_);
  if (result == 0) {
    ++records_in_segment_;
  } else {
    // After a failed sync nobody knows what the file holds: what follows goes to a new one.
    abandon_segment();
  }
  return result;
}

int JournalWriter::begin_segment() {
  const path name = segment_name(folder_, segment_);
  file_ = open_file(disk_, name, Disk::Open::fresh);
  if (file_ < 0) return file_;
  records_in_segment_ = 0;
  const int result = write_all(disk_, file_, segment_header(segment_, next_sequence_));
  return result != 0 ? result : sync_directory(disk_, folder_);
}

void JournalWriter::abandon_segment() {
  if (file_ < 0) return;
  close();
  if (records_in_segment_ > 0) {
    ++segment_;
  } else {
    disk_.remove(segment_name(folder_, segment_));
  }
}

void JournalWriter::close() {
  if (file_ >= 0) disk_.close(file_);
  file_ = -1;
}

JournalReader::JournalReader(path folder) : folder_(std::move(folder)) {
  if (!has_journal(folder_)) {
    throw InputError(folder_.string() +
                     ": no journal-000.nadir in it; give the folder of a dive recorded by nadir");
  }
  open_segment();
}

std::optional<Record> JournalReader::next() {
  do {
    while (auto record = next_in_segment()) {
      if (record->sequence < expected_) continue;
      expected_ = record->sequence + 1;
      return record;
    }
  } while (open_segment());
  return std::nullopt;
}

bool JournalReader::open_segment() {
  const path name = segment_name(folder_, next_segment_);
  std::error_code error;
  file_ = open_to_read(name);
  if (!file_) return false;
  ++next_segment_;
  size_ = std::filesystem::file_size(name, error);
  if (error) size_ = 0;
  position_ = 0;
  Bytes header(kSegmentHeader);
  file_.read(reinterpret_cast<char*>(header.data()), kSegmentHeader);
  std::array<char, 8> magic{};
  std::uint32_t version = 0, number = 0, sum = 0;
  std::uint64_t first_sequence = 0;
  Decoder decoder(header);
  decoder(magic, version, number, first_sequence, sum);
  following_.reset();
  if (next_segment_ == 1) following_ = 0;
  if (!file_ || magic != kSegmentMagic) return true;  // damaged: its records may still be whole
  // Up to version 4 the first record follows without a checksum.
  const bool unsummed = std::equal(kRecordMagic.begin(), kRecordMagic.end(),
                                   header.begin() + static_cast<std::ptrdiff_t>(kSegmentHead));
  if (!unsummed && sum != libdeflate_crc32(0, header.data(), kSegmentHead)) return true;
  if (version > kVersion) {
    throw InputError(name.string() + ": written by a later version of nadir; use that one");
  }
  if (unsummed || version < kVersion) {
    throw InputError(name.string() + ": written by an earlier version of nadir; use that one");
  }
  following_ = first_sequence;
  return true;
}

std::optional<Record> JournalReader::next_in_segment() {
  while (position_ + kRecordHeader <= size_) {
    if (auto record = read_at(position_)) {
      position_ += kRecordHeader + record->payload.size();
      missing_ += record->sequence - std::min(record->sequence, following_.value_or(~0ull));
      following_ = record->sequence + 1;
      return record;
    }
    seek_magic();
  }
  return std::nullopt;
}

std::optional<Record> JournalReader::read_at(std::uint64_t position) {
  Bytes header(kRecordHeader);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(position));
  file_.read(reinterpret_cast<char*>(header.data()), kRecordHeader);
  std::array<std::uint8_t, 4> magic{};
  std::uint32_t size = 0, crc = 0;
  Record record;
  Decoder decoder(header);
  decoder(magic, size, record.type, crc, record.sequence);
  if (!file_ || !std::ranges::equal(magic, kRecordMagic) ||
      size > std::min<std::uint64_t>(kLargestPayload, size_ - position - kRecordHeader)) {
    return std::nullopt;
  }
  record.payload.resize(size);
  file_.read(reinterpret_cast<char*>(record.payload.data()), size);
  if (!file_ || checksum(size, record.type, record.sequence, record.payload) != crc) {
    return std::nullopt;
  }
  return record;
}

// Moves to the next place after this one that looks like a record.
void JournalReader::seek_magic() {
  Bytes chunk(1 << 16);
  ++position_;
  while (position_ + kRecordHeader <= size_) {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(position_));
    file_.read(reinterpret_cast<char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    const auto end = chunk.begin() + file_.gcount();
    const auto found = std::search(chunk.begin(), end, kRecordMagic.begin(), kRecordMagic.end());
    position_ += static_cast<std::uint64_t>(found - chunk.begin());
    if (found != end) return;
    // On, with room for a magic across two chunks; what cannot be read is passed over.
    position_ += static_cast<std::uint64_t>(chunk.end() - end) + 1 - kRecordMagic.size();
  }
}

bool has_journal(const path& folder) {
  std::error_code error;
  return is_regular_file(symlink_status(segment_name(folder, 0), error));
}

}  // namespace nadir::record
