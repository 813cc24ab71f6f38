// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <vector>

#include "codecs.hpp"
#include "png_guard.hpp"

namespace nadir::image_io {
namespace {

struct Reader {
  PngFault fault;
  std::span<const std::uint8_t> rest;
  png_structp png = nullptr;
  png_infop info = nullptr;

  Reader() {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &fault, png_on_error, png_on_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
};

void on_read(png_structp png, png_bytep to, png_size_t size) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (size > reader->rest.size()) png_error(png, "truncated");
  std::memcpy(to, reader->rest.data(), size);
  reader->rest = reader->rest.subspan(size);
}

void read_header(Reader& reader, const Header& header) {
  png_set_read_fn(reader.png, &reader, on_read);
  png_set_user_limits(reader.png, static_cast<png_uint_32>(header.width),
                      static_cast<png_uint_32>(header.height));
  // Compressed texts and profiles are never unpacked.
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(reader.png, reader.info);
}

// Whatever the file holds becomes 8-bit grey or BGR.
void set_transforms(const Reader& reader, Colour colour) {
  const int type = png_get_color_type(reader.png, reader.info);
  png_set_scale_16(reader.png);
  png_set_packing(reader.png);
  if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reader.png);
  if (type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(reader.png);
  png_set_strip_alpha(reader.png);
  const bool stored_grey = (type & PNG_COLOR_MASK_COLOR) == 0;
  if (colour == Colour::bgr) {
    if (stored_grey) png_set_gray_to_rgb(reader.png);
    png_set_bgr(reader.png);
  } else if (!stored_grey) {
    constexpr int kSilently = 1;
    png_set_rgb_to_gray_fixed(reader.png, kSilently, 29900, 58700);  // ITU-R BT.601, as JPEG's Y
  }
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
}

void set_bgra(const Reader& reader) {
  png_set_bgr(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
}

Decoded decode_as(std::span<const std::uint8_t> file, const Header& header, int type,
                  void (*transform)(const Reader&)) {
  Reader reader;
  reader.rest = file;
  const auto damaged = [&] {
    return Decoded{{}, std::string("damaged PNG: ") + reader.fault.text};
  };
  if (reader.info == nullptr) return {{}, "no memory to decode a PNG"};
  std::size_t row_size = 0;
  if (!png_guarded(reader.png, [&] {
        read_header(reader, header);
        transform(reader);
        row_size = png_get_rowbytes(reader.png, reader.info);
      })) {
    return damaged();
  }
  cv::Mat image(header.height, header.width, type);
  if (row_size != image.cols * image.elemSize()) return {{}, "damaged PNG: wrong row size"};
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.rows));
  for (int row = 0; row < image.rows; ++row) rows[static_cast<std::size_t>(row)] = image.ptr(row);
  png_bytepp const row_pointers = rows.data();
  if (!png_guarded(reader.png, [&] {
        png_read_image(reader.png, row_pointers);
        png_read_end(reader.png, nullptr);
      })) {
    return damaged();
  }
  return {image, {}};
}

}  // namespace

Decoded decode_png(std::span<const std::uint8_t> file, const Header& header, Colour colour) {
  if (colour == Colour::grey) {
    return decode_as(file, header, CV_8UC1,
                     [](const Reader& reader) { set_transforms(reader, Colour::grey); });
  }
  return decode_as(file, header, CV_8UC3,
                   [](const Reader& reader) { set_transforms(reader, Colour::bgr); });
}

Decoded decode_png_bgra(std::span<const std::uint8_t> file, const Header& header) {
  return decode_as(file, header, CV_8UC4, set_bgra);
}

}  // namespace nadir::image_io
