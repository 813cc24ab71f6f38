// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "fault.hpp"

namespace nadir::capture::plugin {
namespace {

struct Format {
  std::uint32_t v4l2;
  libcamera::PixelFormat own;
};
const std::array kFormats{
    Format{V4L2_PIX_FMT_NV12, libcamera::formats::NV12},
    Format{V4L2_PIX_FMT_YUYV, libcamera::formats::YUYV},
    Format{V4L2_PIX_FMT_MJPEG, libcamera::formats::MJPEG},
    Format{V4L2_PIX_FMT_GREY, libcamera::formats::R8},
    // libcamera names the bytes from the last to the first.
    Format{V4L2_PIX_FMT_BGR24, libcamera::formats::RGB888},
    Format{V4L2_PIX_FMT_RGB24, libcamera::formats::BGR888},
    Format{V4L2_PIX_FMT_SRGGB8, libcamera::formats::SRGGB8},
    Format{V4L2_PIX_FMT_SGRBG8, libcamera::formats::SGRBG8},
    Format{V4L2_PIX_FMT_SGBRG8, libcamera::formats::SGBRG8},
    Format{V4L2_PIX_FMT_SBGGR8, libcamera::formats::SBGGR8},
    Format{V4L2_PIX_FMT_SRGGB10, libcamera::formats::SRGGB10},
    Format{V4L2_PIX_FMT_SGRBG10, libcamera::formats::SGRBG10},
    Format{V4L2_PIX_FMT_SGBRG10, libcamera::formats::SGBRG10},
    Format{V4L2_PIX_FMT_SBGGR10, libcamera::formats::SBGGR10},
    Format{V4L2_PIX_FMT_SRGGB10P, libcamera::formats::SRGGB10_CSI2P},
    Format{V4L2_PIX_FMT_SGRBG10P, libcamera::formats::SGRBG10_CSI2P},
    Format{V4L2_PIX_FMT_SGBRG10P, libcamera::formats::SGBRG10_CSI2P},
    Format{V4L2_PIX_FMT_SBGGR10P, libcamera::formats::SBGGR10_CSI2P},
};

bool is_yuv(std::uint32_t v4l2) { return v4l2 == V4L2_PIX_FMT_NV12 || v4l2 == V4L2_PIX_FMT_YUYV; }

// The first of the formats that the camera has at that size; nearest: what it has instead.
Choice choose(libcamera::Camera& camera, libcamera::StreamRole role,
              const NadirCameraWanted& wanted, std::string& nearest) {
  const std::vector<libcamera::StreamRole> roles{role};
  auto configuration = camera.generateConfiguration(roles);
  if (!configuration || configuration->empty()) return {};
  libcamera::StreamConfiguration& stream = configuration->at(0);
  const std::vector<libcamera::PixelFormat> offered = stream.formats().pixelformats();
  const libcamera::Size size(static_cast<unsigned>(wanted.width),
                             static_cast<unsigned>(wanted.height));
  for (std::size_t i = 0; i < wanted.format_count; ++i) {
    const std::uint32_t v4l2 = wanted.formats[i];
    const auto format = std::find_if(kFormats.begin(), kFormats.end(),
                                     [&](const Format& f) { return f.v4l2 == v4l2; });
    if (format == kFormats.end() ||
        std::find(offered.begin(), offered.end(), format->own) == offered.end()) {
      continue;
    }
    stream.pixelFormat = format->own;
    stream.size = size;
    stream.stride = 0;
    stream.bufferCount = std::max(stream.bufferCount, kBuffers);
    // As images of V4L2 are read: BT.601, 16 to 235.
    if (is_yuv(v4l2)) stream.colorSpace = libcamera::ColorSpace::Smpte170m;
    if (configuration->validate() == libcamera::CameraConfiguration::Invalid) continue;
    if (stream.pixelFormat == format->own && stream.size == size)
      return {std::move(configuration), v4l2};
    if (nearest.empty()) nearest = stream.size.toString();
  }
  return {};
}

}  // namespace

Choice choose(libcamera::Camera& camera, const NadirCameraWanted& wanted) {
  using libcamera::StreamRole;
  std::string nearest;
  for (const StreamRole role : {StreamRole::VideoRecording, StreamRole::Viewfinder,
                                StreamRole::StillCapture, StreamRole::Raw}) {
    if (Choice choice = choose(camera, role, wanted, nearest); choice.configuration) return choice;
  }
  if (nearest.empty())
    throw Fault("gives no format that is known here (NV12, YUYV, JPEG, RGB, Bayer)");
  throw Fault("does not offer " + std::to_string(wanted.width) + " x " +
              std::to_string(wanted.height) + " px, for which the calibration is, but " + nearest);
}

}  // namespace nadir::capture::plugin
