// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The camera behind the handle.
#pragma once

#include <libcamera/libcamera.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "completed.hpp"
#include "libcamera_plugin.h"
#include "losses.hpp"
#include "mapped.hpp"
#include "stream.hpp"

namespace nadir::capture::plugin {

/// See NadirLibcameraPlugin for each of these.
class OpenCamera {
 public:
  ~OpenCamera() { stop(); }

  void start(const NadirCameraWanted& wanted, NadirCameraOpened& opened);
  NadirCameraTaken take(NadirCameraPicture& picture, NadirText& gone);
  void give_back(void* buffer);
  void expose(double ms, double gain);
  void stop();

 private:
  struct Buffer {
    std::unique_ptr<Mapped> mapped;
    std::vector<std::uint8_t> gathered;  ///< planes that are apart in memory
    libcamera::Request* request = nullptr;
  };

  void read(Buffer& buffer, const libcamera::FrameMetadata& metadata,
            NadirCameraPicture& picture) const;

  const std::shared_ptr<Completed> completed_ = std::make_shared<Completed>();
  std::unique_ptr<Stream> stream_;
  std::vector<Buffer> buffers_;
  std::size_t stride_ = 0, height_ = 0;
  NadirExposing exposing_{};
  Losses losses_;
};

}  // namespace nadir::capture::plugin
