// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include <memory>

#include "codecs.hpp"
#include "jpeg_markers.hpp"

namespace nadir::image_io {
namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Destroy>;

// Each scan of a file visits every block, however few bytes it has. Encoders in use write at most
// 14; thousands would cost minutes.
bool too_many_scans(std::span<const std::uint8_t> file) {
  constexpr int kMostScans = 32;
  int scans = 0;
  JpegMarkers markers(file);
  while (const auto segment = markers.next()) {
    if (segment->marker == kJpegStartOfScan && ++scans > kMostScans) return true;
  }
  return false;
}

Decoded damaged(tjhandle handle) {
  return {{}, std::string("damaged JPEG: ") + tjGetErrorStr2(handle)};
}

}  // namespace

Decoded decode_jpeg(std::span<const std::uint8_t> file, const Header& header, int divisor,
                    Colour colour) {
  if (too_many_scans(file)) return {{}, "JPEG with too many scans"};
  const Handle handle(tjInitDecompress());
  int width = 0, height = 0, subsampling = 0, space = 0;
  if (tjDecompressHeader3(handle.get(), file.data(), file.size(), &width, &height, &subsampling,
                          &space) != 0) {
    return damaged(handle.get());
  }
  if (width != header.width || height != header.height) {
    return {{}, "damaged JPEG: two different sizes"};
  }
  const tjscalingfactor factor{1, divisor};
  const bool grey = colour == Colour::grey;
  cv::Mat image(TJSCALED(height, factor), TJSCALED(width, factor), grey ? CV_8UC1 : CV_8UC3);
  // A warning means missing or wrong data that libjpeg would paint over in grey.
  if (tjDecompress2(handle.get(), file.data(), file.size(), image.data, image.cols,
                    static_cast<int>(image.step), image.rows, grey ? TJPF_GRAY : TJPF_BGR,
                    TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0) {
    return damaged(handle.get());
  }
  return {image, {}};
}

}  // namespace nadir::image_io
