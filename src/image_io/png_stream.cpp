// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "png_stream.hpp"

#include <algorithm>
#include <utility>

#include "nadir/core/check.hpp"
#include "png_format.hpp"

namespace nadir::image_io {
namespace {

// Filtered bytes compressed at once: they stay in the cache between filter and compressor.
constexpr std::size_t kBlock = 65536;

// Of ISA-L. 1206x1137 RGBA projections: level 1 8.7 ms and 1.287 MB, level 2 8.8 ms and 1.268 MB
// with four times the hash table, which a Raspberry Pi's L1 cache does not hold. Others there:
// libdeflate 1 21 ms and 1.229 MB, 3 34 ms and 1.192 MB; zlib 1 52 ms and 1.318 MB.
std::uint32_t isal_level(PngEffort effort) { return effort == PngEffort::fast ? 1 : 2; }

// ISA-L 2.30 (x86, igzip_icf_body) takes the second hash of a stream from the address of the stream
// where it means the data: a match lies two bytes nearer in one of a thousand files, and the same
// pixels give other bytes. Its code for the end of the input hashes right, from four bytes on; so
// the first bytes are flushed alone, which costs ten bytes a file.
constexpr std::size_t kFirstBytes = 4;

}  // namespace

void PngStream::start(int width, int height, int type, PngEffort effort, PngWriter::Sink sink) {
  sink_ = std::move(sink);
  failed_ = false;
  const std::size_t row_size = 1 + static_cast<std::size_t>(width) * CV_ELEM_SIZE(type);
  rows_at_once_ = static_cast<int>(std::max<std::size_t>(1, kBlock / row_size));
  rows_.start(width, type, rows_at_once_);
  if (compressor_ == nullptr) compressor_ = std::make_unique<Compressor>();
  isal_zstream& stream = compressor_->stream;
  isal_deflate_init(&stream);
  stream.gzip_flag = IGZIP_ZLIB;
  stream.level = isal_level(effort);
  stream.level_buf = compressor_->level_buffer.data();
  stream.level_buf_size = stream.level == 1 ? ISAL_DEF_LVL1_MEDIUM : ISAL_DEF_LVL2_MEDIUM;
  stream.next_out = compressor_->out.data();
  stream.avail_out = kChunk;
  send(png_head(width, height, type));
}

bool PngStream::rows(const cv::Mat& rows) {
  for (int row = 0; row < rows.rows && !failed_; row += rows_at_once_) {
    auto filtered = rows_.filtered(rows.rowRange(row, std::min(row + rows_at_once_, rows.rows)));
    if (compressor_->stream.total_in == 0) {
      const auto first = filtered.first(std::min(kFirstBytes, filtered.size()));
      deflate(first, SYNC_FLUSH);
      filtered = filtered.subspan(first.size());
    }
    deflate(filtered, NO_FLUSH);
  }
  return !failed_;
}

bool PngStream::finish() {
  if (!failed_) {
    deflate({}, NO_FLUSH, true);
    send_pixels();
    chunk_.clear();
    append_chunk(chunk_, "IEND", {});
    send(chunk_);
  }
  sink_ = nullptr;
  return !failed_;
}

void PngStream::deflate(std::span<const std::uint8_t> filtered, std::uint16_t flush, bool last) {
  isal_zstream& stream = compressor_->stream;
  stream.next_in = const_cast<std::uint8_t*>(filtered.data());  // only read
  stream.avail_in = static_cast<std::uint32_t>(filtered.size());
  stream.end_of_stream = last ? 1 : 0;
  stream.flush = flush;
  while (!failed_) {
    const int fault = isal_deflate(&stream);
    NADIR_CHECK(fault == COMP_OK, fault);
    if (stream.avail_out > 0) break;  // all was taken
    send_pixels();
  }
  const bool ended = stream.internal_state.state == ZSTATE_END;
  NADIR_CHECK(failed_ || (stream.avail_in == 0 && ended == last), stream.avail_in, ended, last);
}

// What was compressed since the last chunk.
void PngStream::send_pixels() {
  isal_zstream& stream = compressor_->stream;
  const std::size_t size = kChunk - stream.avail_out;
  if (size > 0) {
    chunk_.clear();
    append_chunk(chunk_, "IDAT", {compressor_->out.data(), size});
    send(chunk_);
  }
  stream.next_out = compressor_->out.data();
  stream.avail_out = kChunk;
}

void PngStream::send(std::span<const std::uint8_t> piece) {
  if (!failed_) failed_ = !sink_(piece);
}

}  // namespace nadir::image_io
