// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The V4L2 cameras of this machine, by names that stay.
#pragma once

#include <string>
#include <vector>

namespace nadir::capture {

struct V4l2Device {
  std::string node;    ///< /dev/video0: another after the next start, perhaps
  std::string driver;  ///< uvcvideo
  std::string card;    ///< what the maker calls it
  std::string bus;     ///< where it is plugged in: usb-0000:01:00.0-1.2
  std::string serial;  ///< of a USB camera that has one
};

/// Those that give images, by the number of their node.
std::vector<V4l2Device> v4l2_devices();

/// A node, or why there is none.
struct FoundDevice {
  std::string node, fault;
};

/// name: a path (of /dev/v4l/by-path or by-id), or the bus, serial or card of just one device, or
/// "auto" for the only USB camera. A path is not looked at.
FoundDevice find_v4l2(const std::string& name, const std::vector<V4l2Device>& devices);

}  // namespace nadir::capture
