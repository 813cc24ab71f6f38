// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A walk over the marker segments of a JPEG file (ITU-T T.81 annex B.1).
#pragma once

#include <cstring>

#include "bytes.hpp"

namespace nadir::image_io {

struct JpegSegment {
  int marker = 0;  ///< second byte: 0xc0 for SOF0
  std::span<const std::uint8_t> payload;
};

inline constexpr int kJpegStartOfScan = 0xda;

class JpegMarkers {
 public:
  explicit JpegMarkers(std::span<const std::uint8_t> file) : file_(file) {}

  /// The next segment with a payload, past the coded data of a scan; none at EOI and at damage.
  std::optional<JpegSegment> next() {
    if (in_scan_) skip_coded_data();
    if (at_ >= file_.size() || file_[at_] != 0xff) return std::nullopt;
    while (at_ < file_.size() && file_[at_] == 0xff) ++at_;
    if (at_ >= file_.size()) return std::nullopt;
    const int marker = file_[at_++];
    const auto length = read_uint(file_, at_, 2, ByteOrder::big);
    if (marker == kEndOfImage || !length || *length < 2 || file_.size() - at_ < *length) {
      at_ = file_.size();
      return std::nullopt;
    }
    const JpegSegment segment{marker, file_.subspan(at_ + 2, *length - 2)};
    at_ += *length;
    in_scan_ = marker == kJpegStartOfScan;
    return segment;
  }

 private:
  static constexpr int kEndOfImage = 0xd9, kFirstRestart = 0xd0, kLastRestart = 0xd7;

  void skip_coded_data() {
    while (at_ + 1 < file_.size()) {
      const void* found = std::memchr(file_.data() + at_, 0xff, file_.size() - at_ - 1);
      if (found == nullptr) break;
      at_ = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - file_.data());
      const int next = file_[at_ + 1];
      const bool coded = next == 0 || (next >= kFirstRestart && next <= kLastRestart);
      if (!coded) return;
      at_ += 2;
    }
    at_ = file_.size();
  }

  std::span<const std::uint8_t> file_;
  std::size_t at_ = 2;  ///< after SOI
  bool in_scan_ = false;
};

}  // namespace nadir::image_io
