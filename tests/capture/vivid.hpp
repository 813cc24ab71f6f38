// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The kernel's virtual camera: a real driver whose faults can be switched on
// (docs.kernel.org/admin-guide/media/vivid.html). Needs root and `modprobe vivid`.
#pragma once

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <string>
#include <thread>

#include "v4l2_devices.hpp"

namespace nadir::capture {

/// The nodes of vivid's cameras; empty without it.
inline std::vector<std::string> vivid_nodes() {
  std::vector<std::string> nodes;
  for (const V4l2Device& device : v4l2_devices()) {
    if (device.driver == "vivid") nodes.push_back(device.node);
  }
  return nodes;
}

/// Sets a control by the name that v4l2-ctl shows it under. False when there is none or it is
/// refused.
inline bool set_vivid(const std::string& node, const std::string& name, int value) {
  const int file = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return false;
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  bool done = false;
  while (!done && ::ioctl(file, VIDIOC_QUERYCTRL, &query) == 0) {
    if (name == reinterpret_cast<const char*>(query.name)) {
      v4l2_control control{query.id, value};
      done = ::ioctl(file, VIDIOC_S_CTRL, &control) == 0;
      break;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  ::close(file);
  return done;
}

/// Pulls and plugs all of its cameras.
inline void unplug_vivid() { std::ofstream("/sys/bus/platform/drivers/vivid/unbind") << "vivid.0"; }
inline void plug_vivid() {
  std::ofstream("/sys/bus/platform/drivers/vivid/bind") << "vivid.0" << std::flush;
  // udev gives the nodes their rights by and by.
  for (int i = 0; i < 100 && vivid_nodes().empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

}  // namespace nadir::capture
