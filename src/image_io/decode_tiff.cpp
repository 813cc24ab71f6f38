// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "codecs.hpp"

namespace nadir::image_io {
namespace {

struct Memory {
  std::span<const std::uint8_t> file;
  std::size_t at = 0;
  std::string fault;
};

tmsize_t on_read(thandle_t handle, void* to, tmsize_t size) {
  auto* memory = static_cast<Memory*>(handle);
  const std::size_t left = memory->file.size() - std::min(memory->at, memory->file.size());
  const std::size_t count = std::min(left, static_cast<std::size_t>(std::max<tmsize_t>(size, 0)));
  if (count > 0) std::memcpy(to, memory->file.data() + memory->at, count);
  memory->at += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t on_write(thandle_t, void*, tmsize_t) { return 0; }

toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
  auto* memory = static_cast<Memory*>(handle);
  const toff_t base = whence == SEEK_CUR   ? memory->at
                      : whence == SEEK_END ? memory->file.size()
                                           : 0;
  memory->at = base + offset;
  return memory->at;
}

int on_close(thandle_t) { return 0; }

toff_t on_size(thandle_t handle) { return static_cast<Memory*>(handle)->file.size(); }

int on_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* memory = static_cast<Memory*>(user);
  char text[160];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (memory->fault.empty()) memory->fault = text;
  return 1;
}

int on_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Handle = std::unique_ptr<TIFF, Close>;

Handle open(Memory& memory, std::size_t image_size) {
  constexpr std::size_t kTables = 1 << 20;  // of a codec or a directory
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(2 * image_size + kTables));
  TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, &memory);
  // "m": no mapping of files, there is none.
  Handle tiff(TIFFClientOpenExt("image", "rm", &memory, on_read, on_write, on_seek, on_close,
                                on_size, nullptr, nullptr, options));
  TIFFOpenOptionsFree(options);
  return tiff;
}

bool read_rows(TIFF* tiff, cv::Mat& raw) {
  for (int row = 0; row < raw.rows; ++row) {
    if (TIFFReadScanline(tiff, raw.ptr(row), static_cast<std::uint32_t>(row), 0) != 1) return false;
  }
  return true;
}

bool read_tiles(TIFF* tiff, cv::Mat& raw) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  // Tiles overhang the image by less than themselves; much larger ones are a trap.
  constexpr std::uint32_t kLargest = 1 << 14;
  if (width == 0 || height == 0 || width > kLargest || height > kLargest) return false;
  const std::size_t area = std::size_t{width} * height;
  if (area > 4 * raw.total() + (1u << 16)) return false;
  if (TIFFTileSize(tiff) != static_cast<tmsize_t>(area * raw.elemSize())) return false;
  cv::Mat tile(static_cast<int>(height), static_cast<int>(width), raw.type());
  for (int y = 0; y < raw.rows; y += tile.rows) {
    for (int x = 0; x < raw.cols; x += tile.cols) {
      if (TIFFReadTile(tiff, tile.data, static_cast<std::uint32_t>(x),
                       static_cast<std::uint32_t>(y), 0, 0) < 0) {
        return false;
      }
      const cv::Rect inside(0, 0, std::min(tile.cols, raw.cols - x),
                            std::min(tile.rows, raw.rows - y));
      tile(inside).copyTo(raw(inside + cv::Point(x, y)));
    }
  }
  return true;
}

// Grey, grey and alpha, RGB or RGBA of 8 bits to what was asked for.
cv::Mat convert(const cv::Mat& raw, Colour colour) {
  cv::Mat image = raw;
  if (raw.channels() == 2) cv::extractChannel(raw, image, 0);
  const bool grey = image.channels() == 1;
  const bool alpha = image.channels() == 4;
  cv::Mat result;
  if (colour == Colour::grey) {
    if (grey) return image;
    cv::cvtColor(image, result, alpha ? cv::COLOR_RGBA2GRAY : cv::COLOR_RGB2GRAY);
  } else {
    cv::cvtColor(image, result,
                 grey    ? cv::COLOR_GRAY2BGR
                 : alpha ? cv::COLOR_RGBA2BGR
                         : cv::COLOR_RGB2BGR);
  }
  return result;
}

}  // namespace

Decoded decode_tiff(std::span<const std::uint8_t> file, const Header& header, Colour colour) {
  cv::Mat raw(header.height, header.width,
              CV_MAKETYPE(header.bits == 16 ? CV_16U : CV_8U, header.channels));
  Memory memory{file, 0, {}};
  const auto damaged = [&] { return Decoded{{}, "damaged TIFF: " + memory.fault}; };
  const Handle tiff = open(memory, raw.total() * raw.elemSize());
  if (!tiff) return damaged();
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_COMPRESSION, &compression);
  if (photometric == PHOTOMETRIC_YCBCR) {
    if (compression != COMPRESSION_JPEG) return {{}, "YCbCr TIFF is not supported"};
    TIFFSetField(tiff.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  const bool tiled = TIFFIsTiled(tiff.get()) != 0;
  const bool size_agrees =
      tiled || TIFFScanlineSize(tiff.get()) == static_cast<tmsize_t>(raw.cols * raw.elemSize());
  if (!size_agrees) return {{}, "damaged TIFF: wrong row size"};
  if (!(tiled ? read_tiles(tiff.get(), raw) : read_rows(tiff.get(), raw)) ||
      !memory.fault.empty()) {
    return damaged();
  }
  cv::Mat eight_bit = raw;
  if (header.bits == 16) raw.convertTo(eight_bit, CV_8U, 1. / 257);
  if (photometric == PHOTOMETRIC_MINISWHITE) cv::bitwise_not(eight_bit, eight_bit);
  return {convert(eight_bit, colour), {}};
}

}  // namespace nadir::image_io
