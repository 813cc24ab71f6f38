// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "png_guard.hpp"

namespace nadir::image_io {
namespace {

constexpr png_uint_32 kMostSide = 1 << 20;

void on_read(png_structp png, png_bytep to, png_size_t size) {
  auto* file = static_cast<std::istream*>(png_get_io_ptr(png));
  file->read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(size));
  if (static_cast<png_size_t>(file->gcount()) != size) png_error(png, "truncated");
}

}  // namespace

struct PngReader::State {
  PngFault fault;
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &fault, png_on_error, png_on_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  int width = 0, height = 0, rows_done = 0;

  State() = default;
  ~State() { png_destroy_read_struct(&png, &info, nullptr); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

PngReader::PngReader(std::istream& file) : state_(std::make_unique<State>()) {
  State& s = *state_;
  if (s.info == nullptr) return;
  bool is_bgra = false;
  const bool read = png_guarded(s.png, [&] {
    png_set_read_fn(s.png, &file, on_read);
    png_set_user_limits(s.png, kMostSide, kMostSide);
    // Compressed texts and profiles are never unpacked.
    png_set_keep_unknown_chunks(s.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(s.png, s.info);
    is_bgra = png_get_color_type(s.png, s.info) == PNG_COLOR_TYPE_RGB_ALPHA &&
              png_get_bit_depth(s.png, s.info) == 8 &&
              png_get_interlace_type(s.png, s.info) == PNG_INTERLACE_NONE;
    png_set_bgr(s.png);
    png_read_update_info(s.png, s.info);
  });
  if (!read || !is_bgra) return;
  s.width = static_cast<int>(png_get_image_width(s.png, s.info));
  s.height = static_cast<int>(png_get_image_height(s.png, s.info));
}

PngReader::~PngReader() = default;

int PngReader::width() const { return state_->width; }
int PngReader::height() const { return state_->height; }

bool PngReader::rows(cv::Mat& strip) {
  State& s = *state_;
  NADIR_CHECK(strip.type() == CV_8UC4 && strip.cols == s.width, strip.type(), strip.cols);
  if (strip.rows > s.height - s.rows_done) return false;
  s.rows_done += strip.rows;
  return png_guarded(s.png, [&] {
    for (int row = 0; row < strip.rows; ++row) png_read_row(s.png, strip.ptr(row), nullptr);
  });
}

}  // namespace nadir::image_io
