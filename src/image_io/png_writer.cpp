// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "png_stream.hpp"

namespace nadir::image_io {

struct PngWriter::State {
  int width = 0, height = 0, type = 0;
  PngStream stream;
  int rows_done = 0;
  bool failed = false;
};

PngWriter::PngWriter(int width, int height, int channels, Sink sink, PngEffort effort, int bits)
    : state_(std::make_unique<State>()) {
  NADIR_CHECK(width > 0 && height > 0, width, height);
  NADIR_CHECK(channels == 1 || channels == 3 || channels == 4, channels);
  NADIR_CHECK(bits == 8 || (bits == 16 && channels == 1), bits, channels);
  State& s = *state_;
  s.width = width;
  s.height = height;
  s.type = CV_MAKETYPE(bits == 16 ? CV_16U : CV_8U, channels);
  s.stream.start(width, height, s.type, effort, std::move(sink));
}

PngWriter::~PngWriter() = default;

bool PngWriter::rows(const cv::Mat& strip) {
  State& s = *state_;
  NADIR_CHECK(strip.type() == s.type && strip.cols == s.width, strip.type(), s.type, strip.cols);
  if (s.failed) return false;
  NADIR_CHECK(strip.rows <= s.height - s.rows_done, strip.rows, s.rows_done);
  s.rows_done += strip.rows;
  s.failed = !s.stream.rows(strip);
  return !s.failed;
}

bool PngWriter::finish() {
  State& s = *state_;
  if (s.failed) return false;
  NADIR_CHECK(s.rows_done == s.height, s.rows_done, s.height);
  s.failed = !s.stream.finish();
  return !s.failed;
}

}  // namespace nadir::image_io
