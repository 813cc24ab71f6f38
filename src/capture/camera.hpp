// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// One streaming camera as its driver gives it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "exposure_control.hpp"
#include "nadir/core/time.hpp"
#include "nadir/image_io/raw.hpp"

namespace nadir::capture {

/// What a camera is asked for.
struct CameraMode {
  int width = 0, height = 0;
  double rate_hz = 0;      ///< at least, when the camera can; 0: its fastest
  double exposure_ms = 0;  ///< 0: steered by expose(), or by the camera itself if it cannot be
  double gain = -1;        ///< in its own unit; -1: likewise
  double focus = -1;       ///< in its own unit; -1: as it stands. It never focuses by itself
};

/// How a picture's bytes are to be read.
struct Encoding {
  std::optional<image_io::RawFormat> raw;  ///< none: JPEG
  image_io::BayerOrder order{};
  std::size_t stride = 0;
};

struct Picture {
  Time time = 0;                  ///< CLOCK_MONOTONIC
  std::uint32_t lost_before = 0;  ///< by the driver's own count
  std::string fault;              ///< why it cannot be used; empty when whole
  Encoding encoding;
  std::span<const std::uint8_t> bytes;
  std::shared_ptr<const void> hold;  ///< of the bytes; the camera fills them again without it
};

class Camera {
 public:
  Camera() = default;
  virtual ~Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// For poll(2): readable when there is something to take.
  virtual int descriptor() const = 0;

  struct Taken {
    std::optional<Picture> picture;
    std::string gone;  ///< why the camera has ended; to be opened again
  };
  /// The next picture, the end, or neither yet; never waits.
  virtual Taken take() = 0;
  virtual double rate_hz() const = 0;  ///< of the mode in use; 0: unknown

  /// What it can be set to, and how it is set now; none when it exposes by itself.
  struct Exposing {
    ExposureRange range;
    Exposure now;
  };
  virtual std::optional<Exposing> exposing() const { return std::nullopt; }
  /// From one of the next pictures on; what it does not take it does not tell.
  virtual void expose(const Exposure& exposure) { static_cast<void>(exposure); }
};

struct OpenedCamera {
  std::unique_ptr<Camera> camera;    ///< null: see fault
  std::string fault;                 ///< "/dev/video0: is in use by another program"
  std::vector<std::string> remarks;  ///< what it would not be set to
};

/// Begins to stream. name: of v4l2_devices(), or "auto".
OpenedCamera open_v4l2(const std::string& name, const CameraMode& mode);

/// "libcamera:ID" or "libcamera:auto" by libcamera, any other by V4L2.
OpenedCamera open_camera(const std::string& name, const CameraMode& mode);

}  // namespace nadir::capture
