// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "open_camera.hpp"

#include <algorithm>
#include <cstring>
#include <ctime>
#include <future>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "fault.hpp"
#include "manager.hpp"
#include "settings.hpp"

namespace nadir::capture::plugin {
namespace {

std::int64_t nanoseconds(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

// libcamera's times are CLOCK_BOOTTIME's by its word, CLOCK_MONOTONIC's by most drivers'. Both are
// the same until the machine has slept; then only the former are ahead of the latter's now.
std::int64_t monotonic(std::int64_t time) {
  const std::int64_t now = nanoseconds(CLOCK_MONOTONIC);
  return time <= now ? time : time - (nanoseconds(CLOCK_BOOTTIME) - now);
}

}  // namespace

void OpenCamera::start(const NadirCameraWanted& wanted, NadirCameraOpened& opened) {
  stream_ = std::make_unique<Stream>(wanted, completed_);
  stream_->configure(wanted, opened);
  stride_ = opened.stride;
  height_ = static_cast<std::size_t>(wanted.height);
  for (const auto& buffer : stream_->buffers())
    buffers_.emplace_back().mapped = std::make_unique<Mapped>(*buffer);
  // Now that it is configured it knows its bounds.
  Settings settings(stream_->controls());
  std::string remarks;
  set_focus(settings, wanted, remarks);
  const double frame_us = set_rate(settings, wanted);
  opened.rate_hz = frame_us > 0 ? 1e6 / frame_us : 0;
  exposing_ = set_exposure(settings, frame_us, wanted, remarks);
  // It goes with the last request waiting; sensors show it some frames after.
  constexpr int kSensorDelay = 3;
  if (exposing_.steered != 0) exposing_.delay = static_cast<int>(buffers_.size()) + kSensorDelay;
  opened.exposing = exposing_;
  opened.descriptor = completed_->descriptor();
  write_text(opened.remarks, remarks);
  stream_->start(settings.list());
}

void OpenCamera::read(Buffer& buffer, const libcamera::FrameMetadata& metadata,
                      NadirCameraPicture& picture) const {
  const auto& planes = buffer.mapped->planes();
  const auto used = metadata.planes();
  picture.fault = "libcamera gives no whole image";
  if (planes.empty() || used.size() != planes.size()) return;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (used[i].bytesused == 0 || used[i].bytesused > planes[i].size) return;
  }
  picture.fault = nullptr;
  picture.bytes = planes[0].bytes;
  picture.size = used[0].bytesused;
  if (planes.size() == 1) return;
  // NV12, the only one of several planes that is asked for.
  const std::size_t luma = stride_ * height_, chroma = used[1].bytesused;
  if (planes[1].bytes == planes[0].bytes + luma) {
    picture.size = luma + chroma;
    return;
  }
  buffer.gathered.resize(luma + chroma);
  std::memcpy(buffer.gathered.data(), planes[0].bytes, std::min(luma, planes[0].size));
  std::memcpy(buffer.gathered.data() + luma, planes[1].bytes, chroma);
  picture.bytes = buffer.gathered.data();
  picture.size = buffer.gathered.size();
}

NadirCameraTaken OpenCamera::take(NadirCameraPicture& picture, NadirText& gone) {
  const std::optional<libcamera::Request*> taken = completed_->take();
  if (!taken) return NADIR_TAKEN_NOTHING;
  libcamera::Request* const request = *taken;
  if (request == nullptr || request->status() == libcamera::Request::RequestCancelled) {
    write_text(gone, request == nullptr ? "is not there any more" : "gives no images any more");
    return NADIR_TAKEN_GONE;
  }
  const libcamera::FrameMetadata& frame = request->buffers().begin()->second->metadata();
  const auto stamp = request->metadata().get(libcamera::controls::SensorTimestamp);
  picture.time_ns = monotonic(stamp.value_or(static_cast<std::int64_t>(frame.timestamp)));
  const auto frame_us = request->metadata().get(libcamera::controls::FrameDuration);
  picture.lost_before =
      losses_.before(frame.sequence, picture.time_ns, 1000 * frame_us.value_or(0));
  Buffer& buffer = buffers_.at(request->cookie());
  buffer.request = request;
  buffer.mapped->begin_reading();
  picture.buffer = &buffer;
  if (frame.status == libcamera::FrameMetadata::FrameSuccess) {
    read(buffer, frame, picture);
  } else {
    picture.fault = "libcamera calls it damaged";
  }
  return NADIR_TAKEN_PICTURE;
}

void OpenCamera::give_back(void* given) {
  Buffer& buffer = *static_cast<Buffer*>(given);
  buffer.mapped->end_reading();
  if (stream_) stream_->queue_again(*buffer.request);
}

void OpenCamera::expose(double ms, double gain) {
  if (!stream_ || exposing_.steered == 0) return;
  Settings settings(stream_->controls());
  plugin::expose(settings, std::clamp(ms, exposing_.shortest_ms, exposing_.longest_ms),
                 std::clamp(gain, exposing_.least_gain, exposing_.most_gain));
  stream_->change(settings.list());
}

// libcamera waits for its own thread, and that for drivers: a camera that hangs is left to itself.
void OpenCamera::stop() {
  if (!stream_) return;
  const auto ending = std::make_shared<std::promise<void>>();
  ++hanging;
  try {
    std::thread([stream = std::move(stream_), ending]() mutable {
      stream.reset();
      --hanging;
      ending->set_value();
    }).detach();
    ending->get_future().wait_for(kPatience);
  } catch (const std::system_error&) {  // no thread to be had: it has ended here
    --hanging;
  }
}

}  // namespace nadir::capture::plugin
