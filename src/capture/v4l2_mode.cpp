// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "v4l2_mode.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "ioctl.hpp"
#include "nadir/core/rounded.hpp"

namespace nadir::capture {
namespace {

using image_io::BayerOrder;
using image_io::RawFormat;

struct KnownFormat {
  std::uint32_t pixel_format;
  Encoding encoding;
};

// In the order of preference: colour without loss, colour, and grey.
const std::array kFormats{
    KnownFormat{V4L2_PIX_FMT_NV12, {RawFormat::nv12, {}, 0}},
    KnownFormat{V4L2_PIX_FMT_YUYV, {RawFormat::yuyv, {}, 0}},
    KnownFormat{V4L2_PIX_FMT_MJPEG, {}},
    KnownFormat{V4L2_PIX_FMT_JPEG, {}},
    KnownFormat{V4L2_PIX_FMT_BGR24, {RawFormat::bgr24, {}, 0}},
    KnownFormat{V4L2_PIX_FMT_RGB24, {RawFormat::rgb24, {}, 0}},
    KnownFormat{V4L2_PIX_FMT_SRGGB8, {RawFormat::bayer8, BayerOrder::rggb, 0}},
    KnownFormat{V4L2_PIX_FMT_SGRBG8, {RawFormat::bayer8, BayerOrder::grbg, 0}},
    KnownFormat{V4L2_PIX_FMT_SGBRG8, {RawFormat::bayer8, BayerOrder::gbrg, 0}},
    KnownFormat{V4L2_PIX_FMT_SBGGR8, {RawFormat::bayer8, BayerOrder::bggr, 0}},
    KnownFormat{V4L2_PIX_FMT_SRGGB10, {RawFormat::bayer10, BayerOrder::rggb, 0}},
    KnownFormat{V4L2_PIX_FMT_SGRBG10, {RawFormat::bayer10, BayerOrder::grbg, 0}},
    KnownFormat{V4L2_PIX_FMT_SGBRG10, {RawFormat::bayer10, BayerOrder::gbrg, 0}},
    KnownFormat{V4L2_PIX_FMT_SBGGR10, {RawFormat::bayer10, BayerOrder::bggr, 0}},
    KnownFormat{V4L2_PIX_FMT_SRGGB10P, {RawFormat::bayer10p, BayerOrder::rggb, 0}},
    KnownFormat{V4L2_PIX_FMT_SGRBG10P, {RawFormat::bayer10p, BayerOrder::grbg, 0}},
    KnownFormat{V4L2_PIX_FMT_SGBRG10P, {RawFormat::bayer10p, BayerOrder::gbrg, 0}},
    KnownFormat{V4L2_PIX_FMT_SBGGR10P, {RawFormat::bayer10p, BayerOrder::bggr, 0}},
    KnownFormat{V4L2_PIX_FMT_GREY, {RawFormat::grey, {}, 0}},
};

double in_hz(const v4l2_fract& interval) {
  return interval.numerator > 0 ? static_cast<double>(interval.denominator) / interval.numerator
                                : 0;
}

// Camera makers round: 29.97 is 30.
constexpr double kNearly = 0.95;

struct Offer {
  std::uint32_t pixel_format = 0;
  double rate_hz = 0;     ///< the slowest that is fast enough, else the fastest; 0: not told
  v4l2_fract interval{};  ///< of that rate
};

// Of a format at a size.
Offer offer_of(int device, std::uint32_t pixel_format, const CameraMode& wanted) {
  Offer best{pixel_format, 0, {}};
  const auto better = [&](double rate) {
    const bool enough = wanted.rate_hz > 0 && rate >= kNearly * wanted.rate_hz;
    const bool had_enough = wanted.rate_hz > 0 && best.rate_hz >= kNearly * wanted.rate_hz;
    return enough && had_enough ? rate < best.rate_hz : rate > best.rate_hz;
  };
  v4l2_frmivalenum interval{};
  interval.pixel_format = pixel_format;
  interval.width = static_cast<__u32>(wanted.width);
  interval.height = static_cast<__u32>(wanted.height);
  for (; control(device, VIDIOC_ENUM_FRAMEINTERVALS, interval) == 0; ++interval.index) {
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      if (better(in_hz(interval.discrete)))
        best = {pixel_format, in_hz(interval.discrete), interval.discrete};
      continue;
    }
    // Any rate between two, of which the one wanted is the best.
    const double fastest = in_hz(interval.stepwise.min), slowest = in_hz(interval.stepwise.max);
    if (wanted.rate_hz > slowest && wanted.rate_hz < fastest) {
      constexpr double kUnit = 1000;
      best = {pixel_format,
              wanted.rate_hz,
              {static_cast<__u32>(kUnit), static_cast<__u32>(std::lround(kUnit * wanted.rate_hz))}};
    } else {
      const v4l2_fract end = wanted.rate_hz > 0 && wanted.rate_hz <= slowest
                                 ? interval.stepwise.max
                                 : interval.stepwise.min;
      best = {pixel_format, in_hz(end), end};
    }
    break;
  }
  return best;
}

bool has_size(const v4l2_frmsizeenum& size, const CameraMode& wanted) {
  const auto width = static_cast<__u32>(wanted.width), height = static_cast<__u32>(wanted.height);
  if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE)
    return size.discrete.width == width && size.discrete.height == height;
  const auto& steps = size.stepwise;
  const auto within = [](__u32 value, __u32 least, __u32 most, __u32 step) {
    return value >= least && value <= most && (value - least) % std::max<__u32>(step, 1) == 0;
  };
  return within(width, steps.min_width, steps.max_width, steps.step_width) &&
         within(height, steps.min_height, steps.max_height, steps.step_height);
}

std::string in_words(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

struct Sizes {
  bool fits = false;
  std::string names;  ///< of those there are
};

Sizes sizes_of(int device, std::uint32_t pixel_format, const CameraMode& wanted) {
  Sizes sizes;
  v4l2_frmsizeenum size{};
  size.pixel_format = pixel_format;
  for (; control(device, VIDIOC_ENUM_FRAMESIZES, size) == 0; ++size.index) {
    sizes.fits = sizes.fits || has_size(size, wanted);
    const bool one = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
    const __u32 width = one ? size.discrete.width : size.stepwise.max_width;
    const __u32 height = one ? size.discrete.height : size.stepwise.max_height;
    sizes.names += (sizes.names.empty() ? "" : ", ") + std::string(one ? "" : "up to ") +
                   in_words(static_cast<int>(width), static_cast<int>(height));
    if (!one) break;
  }
  // A driver that lists no sizes is asked by setting one.
  if (size.index == 0 && sizes.names.empty()) sizes.fits = true;
  return sizes;
}

std::vector<std::uint32_t> formats_of(int device) {
  std::vector<std::uint32_t> formats;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; control(device, VIDIOC_ENUM_FMT, description) == 0; ++description.index)
    formats.push_back(description.pixelformat);
  return formats;
}

struct Choice {
  std::optional<Offer> offer;
  std::string fault;
};

Choice choose(int device, const CameraMode& wanted) {
  const std::vector<std::uint32_t> formats = formats_of(device);
  Choice choice;
  std::string sizes;
  bool known = false;
  const auto is_enough = [&](const Offer& offer) {
    return wanted.rate_hz > 0 && offer.rate_hz >= kNearly * wanted.rate_hz;
  };
  for (const KnownFormat& format : kFormats) {
    if (std::ranges::find(formats, format.pixel_format) == formats.end()) continue;
    known = true;
    Sizes offered = sizes_of(device, format.pixel_format, wanted);
    if (!offered.fits) {
      if (sizes.empty()) sizes = std::move(offered.names);
      continue;
    }
    const Offer offer = offer_of(device, format.pixel_format, wanted);
    if (!choice.offer || (!is_enough(*choice.offer) && offer.rate_hz > choice.offer->rate_hz))
      choice.offer = offer;
  }
  if (choice.offer) return choice;
  choice.fault = known ? "does not offer " + in_words(wanted.width, wanted.height) +
                             " px, for which the calibration is, but " + sizes
                       : "gives no format that is known here (NV12, YUYV, JPEG, RGB, Bayer, grey)";
  return choice;
}

std::string set_format(int device, std::uint32_t pixel_format, const CameraMode& wanted,
                       Encoding& encoding) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<__u32>(wanted.width);
  format.fmt.pix.height = static_cast<__u32>(wanted.height);
  format.fmt.pix.pixelformat = pixel_format;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (control(device, VIDIOC_S_FMT, format) != 0)
    return errno == EBUSY ? std::string("is in use by another program")
                          : std::string("takes no format: ") + std::strerror(errno);
  const v4l2_pix_format& set = format.fmt.pix;
  if (set.pixelformat != pixel_format || static_cast<int>(set.width) != wanted.width ||
      static_cast<int>(set.height) != wanted.height) {
    return "gives " + in_words(static_cast<int>(set.width), static_cast<int>(set.height)) +
           " px where " + in_words(wanted.width, wanted.height) + " were asked for";
  }
  if (set.field != V4L2_FIELD_NONE) return "gives interlaced images, which cannot be mapped";
  encoding = *encoding_of(pixel_format);
  encoding.stride = set.bytesperline;
  return {};
}

// The rate it then says it has.
double set_rate(int device, const v4l2_fract& interval) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (control(device, VIDIOC_G_PARM, parameters) != 0) return 0;
  v4l2_captureparm& capture = parameters.parm.capture;
  if ((capture.capability & V4L2_CAP_TIMEPERFRAME) != 0 && interval.numerator > 0) {
    capture.timeperframe = interval;
    control(device, VIDIOC_S_PARM, parameters);
  }
  return in_hz(capture.timeperframe);
}

constexpr double kExposureUnits = 10;  // of V4L2_CID_EXPOSURE_ABSOLUTE, a millisecond

std::optional<v4l2_queryctrl> range_of(int device, std::uint32_t id) {
  v4l2_queryctrl query{};
  query.id = id;
  const bool known = control(device, VIDIOC_QUERYCTRL, query) == 0 &&
                     (query.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) == 0;
  return known ? std::optional(query) : std::nullopt;
}

double value_of(int device, std::uint32_t id) {
  v4l2_control setting{id, 0};
  control(device, VIDIOC_G_CTRL, setting);
  return setting.value;
}

bool set_control(int device, std::uint32_t id, std::int32_t value) {
  v4l2_control setting{id, value};
  return control(device, VIDIOC_S_CTRL, setting) == 0;
}

}  // namespace

std::optional<Encoding> encoding_of(std::uint32_t pixel_format) {
  const auto known = std::ranges::find(kFormats, pixel_format, &KnownFormat::pixel_format);
  return known == kFormats.end() ? std::nullopt : std::optional(known->encoding);
}

std::vector<std::uint32_t> known_formats() {
  std::vector<std::uint32_t> formats;
  for (const KnownFormat& format : kFormats) formats.push_back(format.pixel_format);
  return formats;
}

V4l2Mode set_mode(int device, const CameraMode& wanted) {
  V4l2Mode mode;
  const Choice choice = choose(device, wanted);
  if (!choice.offer) {
    mode.fault = choice.fault;
    return mode;
  }
  mode.fault = set_format(device, choice.offer->pixel_format, wanted, mode.encoding);
  if (mode.fault.empty()) mode.rate_hz = set_rate(device, choice.offer->interval);
  return mode;
}

std::vector<std::string> set_controls(int device, const CameraMode& wanted) {
  std::vector<std::string> refused;
  const auto require = [&](bool done, const std::string& what) {
    if (!done) refused.push_back(what);
  };
  // A lens that moves has another calibration each time.
  if (range_of(device, V4L2_CID_FOCUS_AUTO))
    require(set_control(device, V4L2_CID_FOCUS_AUTO, 0), "its autofocus cannot be turned off");
  if (wanted.focus >= 0) {
    const auto focus = static_cast<std::int32_t>(std::lround(wanted.focus));
    require(set_control(device, V4L2_CID_FOCUS_ABSOLUTE, focus),
            "its focus cannot be set to " + rounded(focus));
  }
  // In the dark a camera would rather give fewer images.
  if (range_of(device, V4L2_CID_EXPOSURE_AUTO_PRIORITY))
    set_control(device, V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
  if (wanted.exposure_ms > 0) {
    const auto units = static_cast<std::int32_t>(std::lround(kExposureUnits * wanted.exposure_ms));
    set_control(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
    require(set_control(device, V4L2_CID_EXPOSURE_ABSOLUTE, std::max(units, 1)),
            "its exposure cannot be set to " + rounded(wanted.exposure_ms) + " ms");
  } else if (range_of(device, V4L2_CID_EXPOSURE_AUTO)) {
    // UVC cameras know one of the two.
    if (!set_control(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY))
      set_control(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO);
  }
  if (wanted.gain >= 0) {
    set_control(device, V4L2_CID_AUTOGAIN, 0);
    require(set_control(device, V4L2_CID_GAIN, static_cast<std::int32_t>(std::lround(wanted.gain))),
            "its gain cannot be set to " + rounded(wanted.gain));
  } else if (range_of(device, V4L2_CID_AUTOGAIN)) {
    set_control(device, V4L2_CID_AUTOGAIN, 1);
  }
  return refused;
}

std::optional<Camera::Exposing> exposing(int device, const CameraMode& wanted) {
  const auto exposure = range_of(device, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (wanted.exposure_ms > 0 || !exposure) return std::nullopt;
  if (!set_control(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL)) return std::nullopt;
  Camera::Exposing found;
  found.range.shortest_ms = exposure->minimum / kExposureUnits;
  found.range.longest_ms = exposure->maximum / kExposureUnits;
  found.now.ms = value_of(device, V4L2_CID_EXPOSURE_ABSOLUTE) / kExposureUnits;
  const auto gain = range_of(device, V4L2_CID_GAIN);
  if (wanted.gain >= 0) {
    found.range.least_gain = found.range.most_gain = found.now.gain = wanted.gain;
  } else if (gain) {
    set_control(device, V4L2_CID_AUTOGAIN, 0);
    found.range.least_gain = gain->minimum;
    found.range.most_gain = gain->maximum;
    found.now.gain = value_of(device, V4L2_CID_GAIN);
  }
  return found;
}

void expose(int device, const Exposure& exposure) {
  const auto whole = [](double value) { return static_cast<std::int32_t>(std::lround(value)); };
  set_control(device, V4L2_CID_EXPOSURE_ABSOLUTE, std::max(whole(kExposureUnits * exposure.ms), 1));
  set_control(device, V4L2_CID_GAIN, whole(exposure.gain));
}

}  // namespace nadir::capture
