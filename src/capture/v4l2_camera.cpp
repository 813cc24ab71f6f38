// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Memory-mapped streaming of V4L2 (docs.kernel.org/userspace-api/media/v4l/mmap.html).
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <utility>

#include "camera.hpp"
#include "file.hpp"
#include "ioctl.hpp"
#include "v4l2_devices.hpp"
#include "v4l2_mode.hpp"

namespace nadir::capture {
namespace {

// A pair's pictures wait for each other while the driver fills the next.
constexpr std::uint32_t kBuffers = 6, kFewestBuffers = 3;

std::string failure(const char* what) { return std::string(what) + ": " + std::strerror(errno); }

v4l2_buffer buffer_of(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

// The open device and its mapped buffers: as long as the camera or any of its pictures is there.
class Stream {
 public:
  explicit Stream(int device) : device_(device) {}
  ~Stream() {
    for (const auto& bytes : buffers_) {
      // The mapping is the driver's to write.
      ::munmap(const_cast<std::uint8_t*>(bytes.data()), bytes.size());  // NOLINT
    }
    ::close(device_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  int device() const { return device_; }

  /// What went wrong; empty when streaming.
  std::string start() {
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (control(device_, VIDIOC_REQBUFS, request) != 0)
      return errno == EBUSY ? "is in use by another program" : failure("gives no buffers");
    if (request.count < kFewestBuffers) return "gives too few buffers";
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = buffer_of(i);
      if (control(device_, VIDIOC_QUERYBUF, buffer) != 0) return failure("gives no buffer");
      void* const memory = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED,
                                  device_, static_cast<off_t>(buffer.m.offset));
      if (memory == MAP_FAILED) return failure("cannot be mapped");
      buffers_.emplace_back(static_cast<std::uint8_t*>(memory), buffer.length);
      if (!give_back(i)) return failure("takes no buffer");
    }
    v4l2_event_subscription change{};
    change.type = V4L2_EVENT_SOURCE_CHANGE;  // not every driver has it
    control(device_, VIDIOC_SUBSCRIBE_EVENT, change);
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    return control(device_, VIDIOC_STREAMON, type) == 0 ? "" : failure("does not stream");
  }

  void end() const {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    control(device_, VIDIOC_STREAMOFF, type);
  }

  bool give_back(std::uint32_t index) const {
    v4l2_buffer buffer = buffer_of(index);
    return control(device_, VIDIOC_QBUF, buffer) == 0;
  }

  std::span<const std::uint8_t> bytes(std::uint32_t index) const { return buffers_.at(index); }

 private:
  int device_;
  std::vector<std::span<const std::uint8_t>> buffers_;
};

// When it was taken, by CLOCK_MONOTONIC; a driver with another clock is late by its delivery.
Time time_of(const v4l2_buffer& buffer) {
  constexpr Time kSecond = 1'000'000'000, kMicrosecond = 1000;
  const bool monotonic =
      (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  return monotonic ? buffer.timestamp.tv_sec * kSecond + buffer.timestamp.tv_usec * kMicrosecond
                   : monotonic_now();
}

class V4l2Camera : public Camera {
 public:
  V4l2Camera(std::shared_ptr<Stream> stream, const V4l2Mode& mode,
             const std::optional<Exposing>& exposing)
      : stream_(std::move(stream)),
        encoding_(mode.encoding),
        rate_hz_(mode.rate_hz),
        exposing_(exposing) {}
  ~V4l2Camera() override { stream_->end(); }

  int descriptor() const override { return stream_->device(); }
  double rate_hz() const override { return rate_hz_; }
  std::optional<Exposing> exposing() const override { return exposing_; }
  void expose(const Exposure& exposure) override { capture::expose(stream_->device(), exposure); }
  Taken take() override;

 private:
  bool has_event() const;
  std::uint32_t lost_before(std::uint32_t sequence);
  Picture picture_of(const v4l2_buffer& buffer);

  std::shared_ptr<Stream> stream_;
  const Encoding encoding_;
  const double rate_hz_;
  const std::optional<Exposing> exposing_;
  std::optional<std::uint32_t> sequence_;
};

bool V4l2Camera::has_event() const {
  pollfd waiting{stream_->device(), POLLPRI, 0};
  return ::poll(&waiting, 1, 0) > 0 && (waiting.revents & POLLPRI) != 0;
}

// The counter wraps; a driver that counts backwards or not at all has lost nothing we know of.
std::uint32_t V4l2Camera::lost_before(std::uint32_t sequence) {
  constexpr std::uint32_t kBackwards = 1u << 31;
  const std::optional<std::uint32_t> before = std::exchange(sequence_, sequence);
  if (!before) return 0;
  const std::uint32_t step = sequence - *before;
  return step == 0 || step >= kBackwards ? 0 : step - 1;
}

Picture V4l2Camera::picture_of(const v4l2_buffer& buffer) {
  Picture picture;
  picture.time = time_of(buffer);
  picture.lost_before = lost_before(buffer.sequence);
  picture.encoding = encoding_;
  const std::span<const std::uint8_t> bytes = stream_->bytes(buffer.index);
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    picture.fault = "the camera's driver calls it damaged";
  } else if (buffer.bytesused == 0 || buffer.bytesused > bytes.size()) {
    picture.fault = "the camera's driver gives no whole image";
  } else {
    picture.bytes = bytes.first(buffer.bytesused);
  }
  // A stream that has ended takes no buffer back, and needs none.
  picture.hold = std::shared_ptr<const void>(
      picture.bytes.data(),
      [stream = stream_, index = buffer.index](const void*) { stream->give_back(index); });
  return picture;
}

Camera::Taken V4l2Camera::take() {
  v4l2_buffer buffer = buffer_of(0);
  if (control(stream_->device(), VIDIOC_DQBUF, buffer) == 0) return {picture_of(buffer), {}};
  if (errno != EAGAIN) return {{}, failure("gives no images any more")};
  if (has_event()) return {{}, "changed the size of its images"};
  return {};
}

std::string prefixed(const std::string& node, const std::string& fault) {
  return printable(node) + ": " + fault;
}

}  // namespace

OpenedCamera open_v4l2(const std::string& name, const CameraMode& wanted) {
  const FoundDevice found =
      find_v4l2(name, name.starts_with('/') ? std::vector<V4l2Device>() : v4l2_devices());
  if (!found.fault.empty()) return {nullptr, found.fault, {}};
  const std::string& node = found.node;
  const int device = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (device < 0) return {nullptr, prefixed(node, std::strerror(errno)), {}};
  const auto stream = std::make_shared<Stream>(device);
  struct stat status {};
  v4l2_capability capability{};
  constexpr __u32 kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if (::fstat(device, &status) != 0 || !S_ISCHR(status.st_mode) ||
      control(device, VIDIOC_QUERYCAP, capability) != 0 ||
      (capability.device_caps & kNeeded) != kNeeded) {
    return {nullptr, prefixed(node, "is no camera that streams by V4L2"), {}};
  }
  const V4l2Mode mode = set_mode(device, wanted);
  if (!mode.fault.empty()) return {nullptr, prefixed(node, mode.fault), {}};
  OpenedCamera opened;
  for (const std::string& refused : set_controls(device, wanted))
    opened.remarks.push_back(prefixed(node, refused));
  const std::optional<Camera::Exposing> exposure = exposing(device, wanted);
  if (const std::string fault = stream->start(); !fault.empty())
    return {nullptr, prefixed(node, fault), {}};
  opened.camera = std::make_unique<V4l2Camera>(stream, mode, exposure);
  return opened;
}

}  // namespace nadir::capture
