// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The journal of a dive: what is in it is recorded, what is not is not.
//
// journal-000.nadir, and -001, ... after each failure of the disk: a segment that failed is never
// written again. A segment is "NADIRJNL", u32 version, u32 its number, u64 sequence of its first
// record, then records: u32 magic "NDRC", u32 size of the payload, u32 type, u32 CRC-32 of the
// other fields and the payload, u64 sequence, payload. Little-endian. Bytes that are no record are
// passed over; sequences rise by one within a segment, so a reader knows how many records are
// missing.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <span>

#include "archive.hpp"
#include "nadir/record/disk.hpp"

namespace nadir::record {

enum class RecordType : std::uint32_t { begin = 1, shot = 2, alert = 3, end = 4, mark = 5 };

struct Record {
  RecordType type{};
  std::uint64_t sequence = 0;
  Bytes payload;
};

class JournalWriter {
 public:
  JournalWriter(Disk& disk, path folder) : disk_(disk), folder_(std::move(folder)) {}
  ~JournalWriter() { close(); }
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  /// One write and one sync. 0 when the record is durable, else -errno: then it was tried in a new
  /// segment too.
  int append(RecordType type, ByteView payload) { return append(type, std::span(&payload, 1)); }
  /// The same of several of one type.
  int append(RecordType type, std::span<const ByteView> payloads);
  void close();

 private:
  int append_once(ByteView records);
  int begin_segment();
  void abandon_segment();

  Disk& disk_;
  path folder_;
  int file_ = -1;
  std::uint32_t segment_ = 0;
  std::uint64_t records_in_segment_ = 0;
  std::uint64_t next_sequence_ = 0;
};

/// Reads all segments in order. Each record is given once, also when a failure left it in two.
class JournalReader {
 public:
  /// Throws InputError when the folder has no journal or one of another version.
  explicit JournalReader(path folder);
  /// The next whole record; none at the end.
  std::optional<Record> next();
  /// Records that were written but could not be read (so far).
  std::uint64_t missing() const { return missing_; }

 private:
  bool open_segment();
  std::optional<Record> next_in_segment();
  std::optional<Record> read_at(std::uint64_t position);
  void seek_magic();

  path folder_;
  std::ifstream file_;
  std::uint32_t next_segment_ = 0;
  std::uint64_t position_ = 0, size_ = 0;
  std::uint64_t expected_ = 0;              ///< sequences below were given already
  std::optional<std::uint64_t> following_;  ///< sequence of the next record of this segment
  std::uint64_t missing_ = 0;
};

/// Whether the folder holds a journal file, be it empty.
bool has_journal(const path& folder);

}  // namespace nadir::record
