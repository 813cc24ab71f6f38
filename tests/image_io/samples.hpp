// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Small images and files of the odd kinds that nadir itself never writes.
#pragma once

#include <png.h>
#include <tiffio.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace nadir::image_io::samples {

using File = std::vector<std::uint8_t>;

/// A smooth image with different channels, so that swapped or lost channels are seen.
inline cv::Mat gradient(int width, int height, int type = CV_8UC3) {
  cv::Mat image(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(40 + 100 * x / width),
                                   static_cast<std::uint8_t>(90 + 120 * y / height),
                                   static_cast<std::uint8_t>(200 - 80 * x / width)};
    }
  }
  if (type == CV_8UC1) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (type == CV_16UC1) {
    cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    image.convertTo(image, CV_16U, 257);
  }
  if (type == CV_8UC4) cv::cvtColor(image, image, cv::COLOR_BGR2BGRA);
  return image;
}

/// Raw rows as they stand: 1, 2, 3 (RGB) or 4 (RGBA) channels of 8 or 16 bits.
inline File raw_png(const cv::Mat& rows, int colour_type, bool interlaced) {
  File file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto on_write = [](png_structp p, png_bytep data, png_size_t size) {
    auto* to = static_cast<File*>(png_get_io_ptr(p));
    to->insert(to->end(), data, data + size);
  };
  png_set_write_fn(png, &file, on_write, [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(rows.cols), static_cast<png_uint_32>(rows.rows),
               rows.depth() == CV_16U ? 16 : 8, colour_type,
               interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
  if (colour_type == PNG_COLOR_TYPE_PALETTE) {
    png_color palette[256];
    for (int i = 0; i < 256; ++i) {
      palette[i] = {static_cast<png_byte>(i), static_cast<png_byte>(255 - i), 7};
    }
    png_set_PLTE(png, info, palette, 256);
  }
  png_write_info(png, info);
  if (rows.depth() == CV_16U) png_set_swap(png);
  std::vector<png_bytep> pointers;
  for (int y = 0; y < rows.rows; ++y) pointers.push_back(const_cast<png_bytep>(rows.ptr(y)));
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return file;
}

/// The pixels as a PNG stores them, by libpng: RGB order, all bits, alpha kept.
inline cv::Mat raw_pixels(const File& file) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const std::uint8_t* at = file.data();
  png_set_read_fn(png, &at, [](png_structp p, png_bytep to, png_size_t size) {
    auto** from = static_cast<const std::uint8_t**>(png_get_io_ptr(p));
    std::copy_n(*from, size, to);
    *from += size;
  });
  png_read_info(png, info);
  const bool deep = png_get_bit_depth(png, info) == 16;
  if (deep) png_set_swap(png);
  cv::Mat pixels(static_cast<int>(png_get_image_height(png, info)),
                 static_cast<int>(png_get_image_width(png, info)),
                 CV_MAKETYPE(deep ? CV_16U : CV_8U, png_get_channels(png, info)));
  for (int y = 0; y < pixels.rows; ++y) png_read_row(png, pixels.ptr(y), nullptr);
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return pixels;
}

struct TiffKind {
  int photometric = PHOTOMETRIC_MINISBLACK;
  int compression = COMPRESSION_NONE;
  bool tiled = false;
  int planar = PLANARCONFIG_CONTIG;
};

/// Raw rows as they stand, in a TIFF of that kind.
inline File raw_tiff(const cv::Mat& rows, const TiffKind& kind) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("nadir_image_io_" + std::to_string(::getpid()) + ".tif");
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, rows.cols);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, rows.rows);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * rows.elemSize1()));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, rows.channels());
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, kind.planar);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_RIGHTTOP);
  if (kind.photometric == PHOTOMETRIC_YCBCR) {
    TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  constexpr int kTile = 32;
  if (kind.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, kTile);
    for (int y = 0; y < rows.rows; y += kTile) {
      for (int x = 0; x < rows.cols; x += kTile) {
        cv::Mat tile = cv::Mat::zeros(kTile, kTile, rows.type());
        const cv::Rect inside(x, y, std::min(kTile, rows.cols - x), std::min(kTile, rows.rows - y));
        rows(inside).copyTo(tile({0, 0, inside.width, inside.height}));
        TIFFWriteTile(tiff, tile.data, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                      0, 0);
      }
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    for (int y = 0; y < rows.rows; ++y) {
      TIFFWriteScanline(tiff, const_cast<std::uint8_t*>(rows.ptr(y)), static_cast<std::uint32_t>(y),
                        0);
    }
  }
  TIFFClose(tiff);
  std::ifstream stream(path, std::ios::binary);
  File file{std::istreambuf_iterator<char>(stream), {}};
  std::filesystem::remove(path);
  return file;
}

inline File cmyk_jpeg(int width, int height) {
  const cv::Mat image(height, width, CV_8UC4, cv::Scalar::all(90));
  tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, image.data, width, 0, height, TJPF_CMYK, &data, &size, TJSAMP_444, 80, 0);
  File file(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return file;
}

inline File progressive_jpeg(const cv::Mat& bgr) {
  tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, bgr.data, bgr.cols, static_cast<int>(bgr.step), bgr.rows, TJPF_BGR, &data,
              &size, TJSAMP_420, 80, TJFLAG_PROGRESSIVE);
  File file(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return file;
}

/// Offset of the first marker segment 0xff 0xMM at or after from; the file's size when absent.
inline std::size_t find_marker(const File& file, std::uint8_t marker, std::size_t from = 0) {
  for (std::size_t i = from; i + 1 < file.size(); ++i) {
    if (file[i] == 0xff && file[i + 1] == marker) return i;
  }
  return file.size();
}

/// The file with a marker segment inserted directly after SOI.
inline File with_segment(File jpeg, std::uint8_t marker, const File& payload) {
  const std::size_t length = payload.size() + 2;
  File segment{0xff, marker, static_cast<std::uint8_t>(length >> 8),
               static_cast<std::uint8_t>(length)};
  segment.insert(segment.end(), payload.begin(), payload.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

inline void append(File& file, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i) file.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// An APP1 payload with orientation, DateTimeOriginal and SubSecTimeOriginal, little-endian.
inline File exif(const std::string& date_time, const std::string& sub_second,
                 std::uint16_t orientation = 1) {
  File file{'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0};
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count,
                         std::uint32_t value) {
    append(file, tag, 2);
    append(file, type, 2);
    append(file, count, 4);
    append(file, value, 4);
  };
  append(file, 8, 4);
  append(file, 2, 2);  // IFD0 at 8
  entry(0x0112, 3, 1, orientation);
  entry(0x8769, 4, 1, 38);
  append(file, 0, 4);
  append(file, 2, 2);  // EXIF IFD at 38
  entry(0x9003, 2, 20, 68);
  std::uint32_t inline_text = 0;
  for (std::size_t i = 0; i < sub_second.size() && i < 3; ++i) {
    inline_text |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(sub_second[i])) << (8 * i);
  }
  entry(0x9291, 2, 4, inline_text);
  append(file, 0, 4);
  file.insert(file.end(), date_time.begin(), date_time.end());  // at 68
  file.push_back(0);
  return file;
}

inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

}  // namespace nadir::image_io::samples
