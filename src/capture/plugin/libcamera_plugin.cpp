// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The plugin linked to libcamera (libcamera.org/api-html), one source for 0.0.3 and what came
// after. Controls are found by their names in what the camera says it has: no version knows them
// all. The image's orientation is left as libcamera has it, upright by how the sensor is mounted.
#include <fcntl.h>
#include <libcamera/libcamera.h>
#include <linux/dma-buf.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "libcamera_plugin.h"
#include "losses.hpp"
#include "steering.hpp"

namespace {

using namespace std::chrono_literals;

// A pair's pictures wait for each other while the camera fills the next.
constexpr unsigned kBuffers = 6;
constexpr auto kPatience = 2s;  // with libcamera, when it ends something

/// Why a camera cannot be opened.
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string failure(const std::string& what, int error) {
  return what + ": " + std::strerror(std::abs(error));
}

void write_text(NadirText& to, const std::string& text) {
  const std::size_t size = std::min(text.size(), sizeof to.text - 1);
  std::copy_n(text.data(), size, std::begin(to.text));
  to.text[size] = 0;
}

// Cameras that libcamera has not let go of within kPatience.
std::atomic<int> hanging{0};

/// libcamera's one manager of a process: as long as there is one of these.
class ManagerUse {
 public:
  ManagerUse() {
    Shared& s = shared();
    const std::unique_lock lock(s.mutex, kPatience);
    if (!lock) throw Fault("libcamera hangs; start the program again");
    if (!s.manager) {
      auto manager = std::make_unique<libcamera::CameraManager>();
      if (const int error = manager->start(); error < 0)
        throw Fault(failure("libcamera does not start", error));
      s.manager = std::move(manager);
    }
    ++s.users;
  }
  ~ManagerUse() {
    Shared& s = shared();
    const std::lock_guard lock(s.mutex);
    if (--s.users > 0) return;
    s.manager->stop();
    s.manager.reset();
  }
  ManagerUse(const ManagerUse&) = delete;
  ManagerUse& operator=(const ManagerUse&) = delete;

  std::vector<std::shared_ptr<libcamera::Camera>> cameras() const {
    return shared().manager->cameras();
  }

 private:
  struct Shared {
    std::timed_mutex mutex;
    std::unique_ptr<libcamera::CameraManager> manager;
    int users = 0;
  };
  static Shared& shared() {
    static Shared& s = *new Shared;  // never ended: libcamera's own statics may be gone by then
    return s;
  }
};

std::shared_ptr<libcamera::Camera> find_camera(const ManagerUse& manager, const std::string& id) {
  std::vector<std::shared_ptr<libcamera::Camera>> fitting;
  std::string ids;
  for (const auto& camera : manager.cameras()) {
    if (camera->id() == id) return camera;
    ids += (ids.empty() ? "" : ", ") + camera->id();
    if (id == "auto" || camera->id().ends_with(id)) fitting.push_back(camera);
  }
  if (fitting.size() == 1) return fitting.front();
  if (ids.empty()) throw Fault("libcamera has no camera");
  throw Fault((fitting.empty() ? "no camera of libcamera is so called, but " : "is one of ") + ids);
}

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

struct Choice {
  std::unique_ptr<libcamera::CameraConfiguration> configuration;  ///< null: none fits
  std::uint32_t v4l2 = 0;
};

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

// Not a number where there is none.
double number_of(const libcamera::ControlValue& value) {
  if (value.isArray()) return std::nan("");
  switch (value.type()) {
    case libcamera::ControlTypeInteger32:
      return value.get<std::int32_t>();
    case libcamera::ControlTypeInteger64:
      return static_cast<double>(value.get<std::int64_t>());
    case libcamera::ControlTypeFloat:
      return value.get<float>();
    default:
      return std::nan("");
  }
}

/// What a camera is set to with a request.
class Settings {
 public:
  explicit Settings(const libcamera::ControlInfoMap& known) : known_(known), list_(known) {}

  bool has(const char* name) const { return find(name) != known_.end(); }

  nadir::capture::Bounds bounds(const char* name) const {
    const auto control = find(name);
    if (control == known_.end()) return {std::nan(""), std::nan("")};
    return {number_of(control->second.min()), number_of(control->second.max())};
  }

  /// Does nothing when the camera has no such control, or not that value.
  bool set(const char* name, double value) {
    const auto control = find(name);
    if (control == known_.end()) return false;
    const auto& [id, info] = *control;
    if (value < number_of(info.min()) || value > number_of(info.max())) return false;
    switch (id->type()) {
      case libcamera::ControlTypeBool:
        list_.set(id->id(), libcamera::ControlValue(value != 0));
        return true;
      case libcamera::ControlTypeInteger32:
        list_.set(id->id(), libcamera::ControlValue(static_cast<std::int32_t>(std::lround(value))));
        return true;
      case libcamera::ControlTypeFloat:
        list_.set(id->id(), libcamera::ControlValue(static_cast<float>(value)));
        return true;
      default:
        return false;
    }
  }

  /// All images of that length; the one it has then, 0 when that is not known.
  double set_frame_us(double frame_us) {
    const auto control = find("FrameDurationLimits");
    if (control == known_.end()) return 0;
    const auto& [id, info] = *control;
    // Not std::clamp: a bound that is not known is not a number.
    if (frame_us < number_of(info.min())) frame_us = number_of(info.min());
    if (frame_us > number_of(info.max())) frame_us = number_of(info.max());
    if (frame_us <= 0) return 0;
    const std::array<std::int64_t, 2> limits{std::llround(frame_us), std::llround(frame_us)};
    list_.set(id->id(), libcamera::ControlValue(libcamera::Span<const std::int64_t>(limits)));
    return frame_us;
  }

  const libcamera::ControlList& list() const { return list_; }

 private:
  libcamera::ControlInfoMap::const_iterator find(const char* name) const {
    return std::find_if(known_.begin(), known_.end(),
                        [&](const auto& control) { return control.first->name() == name; });
  }

  const libcamera::ControlInfoMap& known_;
  libcamera::ControlList list_;
};

void expose(Settings& settings, double ms, double gain) {
  settings.set("ExposureTime", 1000 * ms);
  settings.set("AnalogueGain", gain);
}

// frame_us: 0: unknown.
NadirExposing set_exposure(Settings& settings, double frame_us, const NadirCameraWanted& wanted,
                           std::string& remarks) {
  constexpr double kAuto = 0, kManual = 1;  // of both modes, which 0.5 brought
  const NadirExposing exposing = nadir::capture::steering(
      settings.bounds("ExposureTime"), settings.bounds("AnalogueGain"), frame_us, wanted);
  const bool steered = exposing.steered != 0;
  const bool fixed = wanted.exposure_ms > 0, fixed_gain = wanted.gain >= 0;
  if (settings.has("ExposureTimeMode")) {
    settings.set("ExposureTimeMode", fixed || steered ? kManual : kAuto);
    settings.set("AnalogueGainMode", fixed_gain || steered ? kManual : kAuto);
  } else {
    // With one of them fixed, it still finds the other.
    settings.set("AeEnable", steered || (fixed && fixed_gain) ? 0 : 1);
  }
  if (fixed && !settings.set("ExposureTime", 1000 * wanted.exposure_ms))
    remarks += "its exposure cannot be set to " + std::to_string(wanted.exposure_ms) + " ms\n";
  if (fixed_gain && !settings.set("AnalogueGain", wanted.gain))
    remarks += "its gain cannot be set to " + std::to_string(wanted.gain) + "\n";
  if (steered) expose(settings, exposing.ms, exposing.gain);
  return exposing;
}

void set_focus(Settings& settings, const NadirCameraWanted& wanted, std::string& remarks) {
  // A lens that moves has another calibration each time.
  constexpr double kManual = 0;
  if (settings.has("AfMode") && !settings.set("AfMode", kManual))
    remarks += "its autofocus cannot be turned off\n";
  if (wanted.focus >= 0 && !settings.set("LensPosition", wanted.focus))
    remarks += "its focus cannot be set to " + std::to_string(wanted.focus) + " dioptres\n";
}

// How long a frame then takes; 0: unknown.
double set_rate(Settings& settings, const NadirCameraWanted& wanted) {
  const double frame_us = wanted.rate_hz > 0 ? 1e6 / wanted.rate_hz : 0;  // 0: made the shortest
  return settings.set_frame_us(std::max(frame_us, 1000 * wanted.exposure_ms));
}

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

/// Requests from libcamera's thread to the camera's user: each is one write, which poll(2) sees.
/// Null when the camera is unplugged.
class Completed {
 public:
  Completed() {
    if (::pipe2(ends_.data(), O_CLOEXEC | O_NONBLOCK) != 0) throw Fault(failure("no pipe", errno));
  }
  ~Completed() {
    for (const int end : ends_) ::close(end);
  }
  Completed(const Completed&) = delete;
  Completed& operator=(const Completed&) = delete;

  int descriptor() const { return ends_[0]; }
  void add(libcamera::Request* request) {
    // Takes many more than there are requests.
    if (::write(ends_[1], static_cast<const void*>(&request), kSize) < 0) return;
  }
  std::optional<libcamera::Request*> take() {
    libcamera::Request* request = nullptr;
    if (::read(ends_[0], static_cast<void*>(&request), kSize) < 1) return std::nullopt;
    return request;
  }

 private:
  static constexpr std::size_t kSize = sizeof(void*);
  std::array<int, 2> ends_{-1, -1};
};

/// A request's memory, mapped as long as this is there.
class Mapped {
 public:
  struct Plane {
    const std::uint8_t* bytes;
    std::size_t size;
  };

  explicit Mapped(const libcamera::FrameBuffer& buffer) {
    for (const auto& plane : buffer.planes()) {
      const bool placed = plane.offset != libcamera::FrameBuffer::Plane::kInvalidOffset;
      const std::size_t offset = placed ? plane.offset : 0;
      planes_.push_back({area_of(buffer, plane.fd) + offset, plane.length});
    }
  }
  ~Mapped() {
    for (const Area& area : areas_) ::munmap(area.memory, area.size);
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;

  const std::vector<Plane>& planes() const { return planes_; }

  /// Before and after reading, for processors whose caches do not see what a camera writes.
  void begin_reading() const { sync(DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ); }
  void end_reading() const { sync(DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ); }

 private:
  struct Area {
    libcamera::SharedFD file;
    void* memory;
    std::size_t size;
  };

  // Planes may share a file.
  const std::uint8_t* area_of(const libcamera::FrameBuffer& buffer,
                              const libcamera::SharedFD& file) {
    for (const Area& area : areas_) {
      if (area.file.get() == file.get()) return static_cast<const std::uint8_t*>(area.memory);
    }
    std::size_t size = 0;
    for (const auto& plane : buffer.planes()) {
      const bool placed = plane.offset != libcamera::FrameBuffer::Plane::kInvalidOffset;
      if (plane.fd.get() == file.get())
        size = std::max<std::size_t>(size, (placed ? plane.offset : 0) + std::size_t{plane.length});
    }
    void* const memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
    if (memory == MAP_FAILED) throw Fault(failure("its memory cannot be mapped", errno));
    areas_.push_back({file, memory, size});
    return static_cast<const std::uint8_t*>(memory);
  }

  void sync(std::uint64_t flags) const {
    dma_buf_sync request{flags};
    for (const Area& area : areas_) ::ioctl(area.file.get(), DMA_BUF_IOCTL_SYNC, &request);
  }

  std::vector<Area> areas_;
  std::vector<Plane> planes_;
};

// Devices that libcamera has open and whose drivers have gone. It notices that of USB cameras only,
// and its assertions end the program when another is stopped then.
int lost_devices() {
  constexpr std::string_view kDevice = "/dev/media", kGone = " (deleted)";
  int lost = 0;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const std::string file = std::filesystem::read_symlink(entry.path(), none).string();
    if (file.starts_with(kDevice) && file.ends_with(kGone)) ++lost;
  }
  return lost;
}

/// What libcamera has of a camera; may hang when it ends.
class Stream {
 public:
  Stream(const NadirCameraWanted& wanted, std::shared_ptr<Completed> completed)
      : completed_(std::move(completed)), camera_(find_camera(manager_, wanted.id)) {
    if (const int error = camera_->acquire(); error < 0) {
      throw Fault(error != -EBUSY ? failure("cannot be had", error)
                  : hanging > 0   ? "libcamera hangs; start the program again"
                                  : "is in use by another program");
    }
    acquired_ = true;
  }
  ~Stream() {
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
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  void configure(const NadirCameraWanted& wanted, NadirCameraOpened& opened) {
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

  const std::vector<std::unique_ptr<libcamera::FrameBuffer>>& buffers() const {
    return allocator_->buffers(stream());
  }
  const libcamera::ControlInfoMap& controls() const { return camera_->controls(); }

  void start(const libcamera::ControlList& settings) {
    std::uint64_t cookie = 0;
    for (const auto& buffer : buffers()) {
      auto request = camera_->createRequest(cookie++);
      if (!request || request->addBuffer(stream(), buffer.get()) < 0)
        throw Fault("takes no request");
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

  /// With the next request that is queued again; what is set stays set.
  void change(const libcamera::ControlList& settings) { changes_ = settings; }

  // One that the camera does not take has gone with it, of which it tells.
  void queue_again(libcamera::Request& request) {
    request.reuse(libcamera::Request::ReuseBuffers);
    request.controls().merge(changes_);
    changes_.clear();
    camera_->queueRequest(&request);
  }

 private:
  libcamera::Stream* stream() const { return configuration_->at(0).stream(); }
  void complete(libcamera::Request* request) { completed_->add(request); }
  void disconnect() {
    told_gone_ = true;
    completed_->add(nullptr);
  }
  void disconnect_signals() {
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
  }
  // Those of cameras abandoned before stay open.
  static bool has_lost_driver() {
    static std::atomic<int> known{0};
    const int lost = lost_devices();
    return lost > known.exchange(lost);
  }
  // Left as it is for ever; libcamera's next manager knows nothing of it.
  void abandon() {
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

/// The camera behind the handle.
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
  std::uint32_t format_ = 0;
  std::size_t stride_ = 0, height_ = 0;
  NadirExposing exposing_{};
  nadir::capture::Losses losses_;
};

void OpenCamera::start(const NadirCameraWanted& wanted, NadirCameraOpened& opened) {
  stream_ = std::make_unique<Stream>(wanted, completed_);
  stream_->configure(wanted, opened);
  format_ = opened.format;
  stride_ = opened.stride;
  height_ = static_cast<std::size_t>(wanted.height);
  for (const auto& buffer : stream_->buffers())
    buffers_.push_back({std::make_unique<Mapped>(*buffer), {}, nullptr});
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
  ::expose(settings, std::clamp(ms, exposing_.shortest_ms, exposing_.longest_ms),
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

void open_camera(const NadirCameraWanted* wanted, NadirCameraOpened* opened) {
  *opened = {};
  std::unique_ptr<OpenCamera> camera;
  try {
    camera = std::make_unique<OpenCamera>();
    camera->start(*wanted, *opened);
    opened->camera = camera.release();
  } catch (const std::exception& error) {
    write_text(opened->fault, error.what());
  }
}

NadirCameraTaken take(void* camera, NadirCameraPicture* picture, NadirText* gone) {
  *picture = {};
  try {
    return static_cast<OpenCamera*>(camera)->take(*picture, *gone);
  } catch (const std::exception& error) {
    write_text(*gone, error.what());
    return NADIR_TAKEN_GONE;
  }
}

void give_back(void* camera, void* buffer) { static_cast<OpenCamera*>(camera)->give_back(buffer); }
void expose_camera(void* camera, double ms, double gain) {
  static_cast<OpenCamera*>(camera)->expose(ms, gain);
}
void stop(void* camera) { static_cast<OpenCamera*>(camera)->stop(); }
void close_camera(void* camera) { delete static_cast<OpenCamera*>(camera); }

}  // namespace

const NadirLibcameraPlugin* nadir_libcamera_plugin() {
  static const std::string version = libcamera::CameraManager::version();
  static const NadirLibcameraPlugin plugin{
      NADIR_LIBCAMERA_ABI, version.c_str(), open_camera, take,
      give_back,           expose_camera,   stop,        close_camera};
  return &plugin;
}
