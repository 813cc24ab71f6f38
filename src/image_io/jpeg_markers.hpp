// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A walk over the marker segments of a JPEG file (ITU-T T.81 annex B.1) up to the first scan.
#pragma once

#include "bytes.hpp"

namespace nadir::image_io {

struct JpegSegment {
  int marker = 0;  ///< second byte: 0xc0 for SOF0
  std::span<const std::uint8_t> payload;
};

class JpegMarkers {
 public:
  explicit JpegMarkers(std::span<const std::uint8_t> file) : file_(file) {}

  /// None at the end of the bytes, at damage, at EOI and after the start of the first scan.
  std::optional<JpegSegment> next() {
    if (ended_) return std::nullopt;
    ended_ = true;
    if (at_ >= file_.size() || file_[at_] != 0xff) return std::nullopt;
    while (at_ < file_.size() && file_[at_] == 0xff) ++at_;
    if (at_ >= file_.size()) return std::nullopt;
    const int marker = file_[at_++];
    const auto length = read_uint(file_, at_, 2, ByteOrder::big);
    if (marker == kEndOfImage || !length || *length < 2 || file_.size() - at_ < *length) {
      return std::nullopt;
    }
    const JpegSegment segment{marker, file_.subspan(at_ + 2, *length - 2)};
    at_ += *length;
    ended_ = marker == kStartOfScan;
    return segment;
  }

 private:
  static constexpr int kEndOfImage = 0xd9, kStartOfScan = 0xda;

  std::span<const std::uint8_t> file_;
  std::size_t at_ = 2;  ///< after SOI
  bool ended_ = false;
};

}  // namespace nadir::image_io
