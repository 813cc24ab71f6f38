// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "v4l2_devices.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "file.hpp"
#include "image_list.hpp"
#include "ioctl.hpp"
#include "nadir/core/entries.hpp"

namespace nadir::capture {

namespace fs = std::filesystem;

namespace {

// A fixed field of the driver's, with or without a zero at its end.
template <std::size_t N>
std::string text_of(const __u8 (&field)[N]) {
  return printable(std::string(field, std::find(field, field + N, 0)));
}

// The serial number stands with the USB device, some folders above its video node.
std::string serial_of(const std::string& node) {
  std::error_code error;
  fs::path folder = fs::canonical(
      "/sys/class/video4linux/" + fs::path(node).filename().string() + "/device", error);
  for (int up = 0; !error && up < 3 && folder.has_relative_path(); ++up) {
    std::string serial;
    if (std::ifstream(folder / "serial") >> serial) return printable(serial);
    folder = folder.parent_path();
  }
  return {};
}

std::optional<V4l2Device> device_at(const std::string& node) {
  const int file = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  v4l2_capability capability{};
  const bool known = control(file, VIDIOC_QUERYCAP, capability) == 0;
  ::close(file);
  constexpr __u32 kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if (!known || (capability.device_caps & kNeeded) != kNeeded) return std::nullopt;
  return V4l2Device{node, text_of(capability.driver), text_of(capability.card),
                    text_of(capability.bus_info), serial_of(node)};
}

std::string listed(const std::vector<V4l2Device>& devices) {
  if (devices.empty()) return "no camera is there";
  std::string list = "there are";
  for (const V4l2Device& device : devices) {
    list += (&device == &devices.front() ? " '" : ", '") + device.card + "' at " + device.bus +
            (device.serial.empty() ? "" : ", serial " + device.serial) + " (" + device.node + ")";
  }
  return list;
}

FoundDevice the_only(const std::vector<V4l2Device>& devices,
                     const std::function<bool(const V4l2Device&)>& wanted,
                     const std::string& what) {
  std::vector<V4l2Device> found;
  std::ranges::copy_if(devices, std::back_inserter(found), wanted);
  if (found.size() == 1) return {found.front().node, {}};
  if (found.empty()) return {{}, "there is no " + what + "; " + listed(devices)};
  return {{}, "more than one is a " + what + "; " + listed(found)};
}

}  // namespace

std::vector<V4l2Device> v4l2_devices() {
  std::vector<std::string> nodes;
  for (const fs::path& entry : entries_of("/dev")) {
    if (entry.filename().string().starts_with("video")) nodes.push_back(entry.string());
  }
  std::ranges::sort(nodes, natural_less);
  std::vector<V4l2Device> devices;
  for (const std::string& node : nodes) {
    if (auto device = device_at(node)) devices.push_back(*std::move(device));
  }
  return devices;
}

FoundDevice find_v4l2(const std::string& name, const std::vector<V4l2Device>& devices) {
  if (name.starts_with('/')) return {name, {}};
  if (name == "auto") {
    return the_only(
        devices, [](const V4l2Device& device) { return device.driver == "uvcvideo"; },
        "USB camera");
  }
  return the_only(
      devices,
      [&](const V4l2Device& device) {
        return !name.empty() &&
               (name == device.bus || name == device.serial || name == device.card);
      },
      "camera '" + name + "'");
}

}  // namespace nadir::capture
