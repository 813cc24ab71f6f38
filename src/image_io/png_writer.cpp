// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/check.hpp"
#include "nadir/image_io/encode.hpp"
#include "png_format.hpp"
#include "png_guard.hpp"

namespace nadir::image_io {

struct PngWriter::State {
  int width = 0, height = 0, type = 0;
  Sink sink;
  PngFault fault;
  png_structp png = nullptr;
  png_infop info = nullptr;
  int rows_done = 0;
  bool failed = false;

  ~State() { png_destroy_write_struct(&png, &info); }
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
  s.sink = std::move(sink);
  s.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &s.fault, png_on_error, png_on_warning);
  NADIR_CHECK(s.png != nullptr);
  s.info = png_create_info_struct(s.png);
  NADIR_CHECK(s.info != nullptr);
  const auto on_write = [](png_structp png, png_bytep data, png_size_t size) {
    auto* state = static_cast<State*>(png_get_io_ptr(png));
    if (!state->sink({data, size})) png_error(png, "the sink failed");
  };
  const auto on_flush = [](png_structp) {};
  png_set_write_fn(s.png, &s, on_write, on_flush);
  s.failed = !png_guarded(s.png, [&] {
    png_set_user_limits(s.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_filter(s.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_set_compression_level(s.png, compression_level(effort));
    png_set_IHDR(s.png, s.info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                 bits, png_colour_type(channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(s.png, s.info);
    png_set_bgr(s.png);
    if (bits == 16) png_set_swap(s.png);
  });
}

PngWriter::~PngWriter() = default;

bool PngWriter::rows(const cv::Mat& strip) {
  State& s = *state_;
  NADIR_CHECK(strip.type() == s.type && strip.cols == s.width, strip.type(), s.type, strip.cols);
  if (s.failed) return false;
  NADIR_CHECK(strip.rows <= s.height - s.rows_done, strip.rows, s.rows_done);
  s.rows_done += strip.rows;
  s.failed = !png_guarded(s.png, [&] {
    for (int row = 0; row < strip.rows; ++row) png_write_row(s.png, strip.ptr(row));
  });
  return !s.failed;
}

bool PngWriter::finish() {
  State& s = *state_;
  if (s.failed) return false;
  NADIR_CHECK(s.rows_done == s.height, s.rows_done, s.height);
  s.failed = !png_guarded(s.png, [&] { png_write_end(s.png, nullptr); });
  return !s.failed;
}

}  // namespace nadir::image_io
