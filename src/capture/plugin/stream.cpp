// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "stream.hpp"

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "fault.hpp"
#include "formats.hpp"

namespace nadir::capture::plugin {
namespace {

// Devices that libcamera has open and whose drivers have gone. It notices that of USB cameras only,
// and its assertions end the program when another is stopped then.
int lost_devices() {
  constexpr std::string_view kDevice = "/dev/media", kGone = " (deleted)";
  int lost = 0;
  std::error_code none;
  // By hand: a range-based loop may throw.
  for (std::filesystem::directory_iterator at("/proc/self/fd", none), end; at != end;
       at.increment(none)) {
    const std::string file = std::filesystem::read_symlink(at->path(), none).string();
    if (file.starts_with(kDevice) && file.ends_with(kGone)) ++lost;
  }
  return lost;
}

// Those of cameras abandoned before stay open.
bool has_lost_driver() {
  static std::atomic<int> known{0};
  const int lost = lost_devices();
  return lost > known.exchange(lost);
}

}  // namespace

Stream::Stream(const NadirCameraWanted& wanted, std::shared_ptr<Completed> completed)
    : completed_(std::move(completed)), camera_(find_camera(manager_, wanted.id)) {
  if (const int error = camera_->acquire(); error < 0) {
    throw Fault(error != -EBUSY ? failure("cannot be had", error)
                : hanging > 0   ? "libcamera hangs; start the program again"
                                : "is in use by another program");
  }
  acquired_ = true;
}

Stream::~Stream() {
  if (started_ && !told_gone_ && has_lost_driver()) {
    abandon();
    return;
  }
  if (started_) camera_->stop();
  disconnect_signals();
  requests_.clear();
  allocator_.reset();
  if (acquired_) camera_->release();
}

void Stream::configure(const NadirCameraWanted& wanted, NadirCameraOpened& opened) {
  auto [configuration, v4l2] = choose(*camera_, wanted);
  configuration_ = std::move(configuration);
  if (const int error = camera_->configure(configuration_.get()); error < 0)
    throw Fault(failure("cannot be configured", error));
  opened.format = v4l2;
  opened.stride = configuration_->at(0).stride;
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (const int error = allocator_->allocate(stream()); error < 0)
    throw Fault(failure("gives no memory", error));
}

void Stream::start(const libcamera::ControlList& settings) {
  std::uint64_t cookie = 0;
  for (const auto& buffer : buffers()) {
    auto request = camera_->createRequest(cookie++);
    if (!request || request->addBuffer(stream(), buffer.get()) < 0) throw Fault("takes no request");
    requests_.push_back(std::move(request));
  }
  // Some pipelines look at what they are started with, some at requests only.
  if (!requests_.empty()) requests_.front()->controls().merge(settings);
  camera_->requestCompleted.connect(this, &Stream::complete);
  camera_->disconnected.connect(this, &Stream::disconnect);
  if (const int error = camera_->start(&settings); error < 0)
    throw Fault(failure("does not stream", error));
  started_ = true;
  for (const auto& request : requests_) {
    if (const int error = camera_->queueRequest(request.get()); error < 0)
      throw Fault(failure("takes no request", error));
  }
}

// One that the camera does not take has gone with it, of which it tells.
void Stream::queue_again(libcamera::Request& request) {
  request.reuse(libcamera::Request::ReuseBuffers);
  request.controls().merge(changes_);
  changes_.clear();
  camera_->queueRequest(&request);
}

void Stream::disconnect() {
  told_gone_ = true;
  completed_->add(nullptr);
}

void Stream::disconnect_signals() {
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
}

// Left as it is for ever; libcamera's next manager knows nothing of it.
void Stream::abandon() {
  struct Abandoned {
    std::shared_ptr<libcamera::Camera> camera;
    std::unique_ptr<libcamera::CameraConfiguration> configuration;
    std::unique_ptr<libcamera::FrameBufferAllocator> allocator;
    std::vector<std::unique_ptr<libcamera::Request>> requests;
    Abandoned* before;
  };
  static std::atomic<Abandoned*> newest{nullptr};
  disconnect_signals();
  newest = new Abandoned{std::move(camera_), std::move(configuration_), std::move(allocator_),
                         std::move(requests_), newest};
}

}  // namespace nadir::capture::plugin
