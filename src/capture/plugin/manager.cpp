// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "manager.hpp"

#include <mutex>
#include <utility>

#include "fault.hpp"

namespace nadir::capture::plugin {
namespace {

struct Shared {
  std::timed_mutex mutex;
  std::unique_ptr<libcamera::CameraManager> manager;
  int users = 0;
};

Shared& shared() {
  static Shared& s = *new Shared;  // never ended: libcamera's own statics may be gone by then
  return s;
}

}  // namespace

ManagerUse::ManagerUse() {
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

ManagerUse::~ManagerUse() {
  Shared& s = shared();
  const std::lock_guard lock(s.mutex);
  if (--s.users > 0) return;
  s.manager->stop();
  s.manager.reset();
}

std::vector<std::shared_ptr<libcamera::Camera>> ManagerUse::cameras() const {
  return shared().manager->cameras();
}

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

}  // namespace nadir::capture::plugin
