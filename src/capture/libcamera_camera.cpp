// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "libcamera_camera.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>

#include "file.hpp"
#include "libcamera_plugin.h"
#include "nadir/core/entries.hpp"
#include "v4l2_mode.hpp"

namespace nadir::capture {
namespace {

namespace fs = std::filesystem;

struct LoadedPlugin {
  const NadirLibcameraPlugin* plugin = nullptr;  ///< stays loaded: libcamera's threads may be in it
  std::string fault;
};

LoadedPlugin load(const fs::path& file) {
  void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return {nullptr, ::dlerror()};
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as dlsym(3) has it
  const auto entry =
      reinterpret_cast<decltype(&nadir_libcamera_plugin)>(::dlsym(library, NADIR_LIBCAMERA_ENTRY));
  const NadirLibcameraPlugin* const plugin = entry == nullptr ? nullptr : entry();
  if (plugin != nullptr && plugin->abi == NADIR_LIBCAMERA_ABI) return {plugin, {}};
  ::dlclose(library);
  return {nullptr, file.string() + ": is of another version of nadir"};
}

bool is_plugin(const fs::path& file) {
  return file.filename().string().starts_with("nadir-libcamera-") && file.extension() == ".so";
}

LoadedPlugin load_first(const fs::path& folder) {
  std::vector<fs::path> files = entries_of(folder);
  std::erase_if(files, [](const fs::path& file) { return !is_plugin(file); });
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return ::strverscmp(a.c_str(), b.c_str()) > 0;
  });
  const std::string remedy = "install the package nadir-libcamera of this system's libcamera";
  LoadedPlugin loaded{nullptr, "there is no plugin for libcamera in " + folder.string()};
  for (const fs::path& file : files) {
    loaded = load(file);
    if (loaded.plugin != nullptr) return loaded;
  }
  return {nullptr, loaded.fault + "; " + remedy};
}

// The camera: as long as it or any of its pictures is there.
class Session {
 public:
  Session(const NadirLibcameraPlugin& plugin, void* camera) : plugin_(plugin), camera_(camera) {}
  ~Session() { plugin_.close(camera_); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  NadirCameraTaken take(NadirCameraPicture& picture, NadirText& gone) const {
    return plugin_.take(camera_, &picture, &gone);
  }
  void give_back(void* buffer) const { plugin_.give_back(camera_, buffer); }
  void expose(const Exposure& exposure) const {
    plugin_.expose(camera_, exposure.ms, exposure.gain);
  }
  void stop() const { plugin_.stop(camera_); }

 private:
  const NadirLibcameraPlugin& plugin_;
  void* const camera_;
};

std::optional<Camera::Exposing> exposing_of(const NadirExposing& opened) {
  if (opened.steered == 0) return std::nullopt;
  return Camera::Exposing{
      {opened.shortest_ms, opened.longest_ms, opened.least_gain, opened.most_gain, opened.delay},
      {opened.ms, opened.gain}};
}

class LibcameraCamera : public Camera {
 public:
  LibcameraCamera(std::shared_ptr<Session> session, const NadirCameraOpened& opened,
                  const Encoding& encoding)
      : session_(std::move(session)),
        descriptor_(opened.descriptor),
        rate_hz_(opened.rate_hz),
        exposing_(exposing_of(opened.exposing)),
        encoding_(encoding) {}
  ~LibcameraCamera() override { session_->stop(); }

  int descriptor() const override { return descriptor_; }
  double rate_hz() const override { return rate_hz_; }
  std::optional<Exposing> exposing() const override { return exposing_; }
  void expose(const Exposure& exposure) override {
    if (exposing_) session_->expose(exposure);
  }
  Taken take() override;

 private:
  const std::shared_ptr<Session> session_;
  const int descriptor_;
  const double rate_hz_;
  const std::optional<Exposing> exposing_;
  const Encoding encoding_;
};

Camera::Taken LibcameraCamera::take() {
  NadirCameraPicture taken{};
  NadirText gone{};
  switch (session_->take(taken, gone)) {
    case NADIR_TAKEN_NOTHING:
      return {};
    case NADIR_TAKEN_GONE:
      return {{}, gone.text};
    case NADIR_TAKEN_PICTURE:
      break;
  }
  Picture picture;
  picture.time = taken.time_ns;
  picture.lost_before = taken.lost_before;
  picture.encoding = encoding_;
  if (taken.fault != nullptr) {
    picture.fault = taken.fault;
  } else {
    picture.bytes = {taken.bytes, taken.size};
  }
  picture.hold = std::shared_ptr<const void>(
      taken.bytes,
      [session = session_, buffer = taken.buffer](const void*) { session->give_back(buffer); });
  return {std::move(picture), {}};
}

}  // namespace

fs::path plugin_folder() {
  const char* const elsewhere = std::getenv("NADIR_PLUGINS");
  return elsewhere == nullptr ? NADIR_PLUGIN_FOLDER : elsewhere;
}

OpenedCamera open_libcamera(const std::string& id, const CameraMode& mode, const fs::path& folder) {
  const std::string named = "libcamera:" + printable(id) + ": ";
  const LoadedPlugin loaded = load_first(folder);
  if (loaded.plugin == nullptr) return {nullptr, named + loaded.fault, {}};
  const std::vector<std::uint32_t> formats = known_formats();
  const NadirCameraWanted wanted{id.c_str(),   mode.width,       mode.height,
                                 mode.rate_hz, mode.exposure_ms, mode.gain,
                                 mode.focus,   formats.data(),   formats.size()};
  NadirCameraOpened opened{};
  loaded.plugin->open(&wanted, &opened);
  if (opened.camera == nullptr) return {nullptr, named + opened.fault.text, {}};
  const auto session = std::make_shared<Session>(*loaded.plugin, opened.camera);
  auto encoding = encoding_of(opened.format).value_or(Encoding{});
  encoding.stride = opened.stride;
  OpenedCamera result;
  result.camera = std::make_unique<LibcameraCamera>(session, opened, encoding);
  std::istringstream remarks(opened.remarks.text);
  for (std::string remark; std::getline(remarks, remark);) result.remarks.push_back(named + remark);
  return result;
}

OpenedCamera open_camera(const std::string& name, const CameraMode& mode) {
  constexpr std::string_view kLibcamera = "libcamera:";
  return name.starts_with(kLibcamera) ? open_libcamera(name.substr(kLibcamera.size()), mode)
                                      : open_v4l2(name, mode);
}

}  // namespace nadir::capture
