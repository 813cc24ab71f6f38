// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A camera that streams.
#pragma once

#include <libcamera/libcamera.h>

#include <atomic>
#include <memory>
#include <vector>

#include "completed.hpp"
#include "libcamera_plugin.h"
#include "manager.hpp"

namespace nadir::capture::plugin {

/// What libcamera has of a camera; may hang when it ends. Throws Fault.
class Stream {
 public:
  Stream(const NadirCameraWanted& wanted, std::shared_ptr<Completed> completed);
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  void configure(const NadirCameraWanted& wanted, NadirCameraOpened& opened);

  // Once it is configured.
  const std::vector<std::unique_ptr<libcamera::FrameBuffer>>& buffers() const {
    return allocator_->buffers(stream());
  }
  const libcamera::ControlInfoMap& controls() const { return camera_->controls(); }

  void start(const libcamera::ControlList& settings);

  /// With the next request that is queued again; what is set stays set.
  void change(const libcamera::ControlList& settings) { changes_ = settings; }
  void queue_again(libcamera::Request& request);

 private:
  libcamera::Stream* stream() const { return configuration_->at(0).stream(); }
  void complete(libcamera::Request* request) { completed_->add(request); }
  void disconnect();
  void disconnect_signals();
  void abandon();

  const std::shared_ptr<Completed> completed_;
  const ManagerUse manager_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  libcamera::ControlList changes_;
  bool acquired_ = false, started_ = false;
  std::atomic<bool> told_gone_{false};
};

}  // namespace nadir::capture::plugin
