// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// libcamera's one manager of a process, and the cameras that it has.
#pragma once

#include <libcamera/libcamera.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace nadir::capture::plugin {

constexpr std::chrono::seconds kPatience{2};  // with libcamera, when it ends something

/// Cameras that libcamera has not let go of within kPatience.
inline std::atomic<int> hanging{0};

/// The manager is there as long as there is one of these.
class ManagerUse {
 public:
  ManagerUse();
  ~ManagerUse();
  ManagerUse(const ManagerUse&) = delete;
  ManagerUse& operator=(const ManagerUse&) = delete;

  std::vector<std::shared_ptr<libcamera::Camera>> cameras() const;
};

/// As NadirCameraWanted has it; throws Fault.
std::shared_ptr<libcamera::Camera> find_camera(const ManagerUse& manager, const std::string& id);

}  // namespace nadir::capture::plugin
