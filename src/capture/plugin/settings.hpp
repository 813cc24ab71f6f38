// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a camera is set to. Controls are found by their names in what the camera says it has: no
// version of libcamera knows them all.
#pragma once

#include <libcamera/libcamera.h>

#include <string>

#include "libcamera_plugin.h"
#include "steering.hpp"

namespace nadir::capture::plugin {

/// Of one request.
class Settings {
 public:
  explicit Settings(const libcamera::ControlInfoMap& known) : known_(known), list_(known) {}

  bool has(const char* name) const { return find(name) != known_.end(); }
  Bounds bounds(const char* name) const;

  /// Does nothing when the camera has no such control, or not that value.
  bool set(const char* name, double value);
  /// All images of that length; the one it has then, 0 when that is not known.
  double set_frame_us(double frame_us);

  const libcamera::ControlList& list() const { return list_; }

 private:
  libcamera::ControlInfoMap::const_iterator find(const char* name) const;

  const libcamera::ControlInfoMap& known_;
  libcamera::ControlList list_;
};

// What a camera begins with; remarks: what it would not be set to, a line each.

void set_focus(Settings& settings, const NadirCameraWanted& wanted, std::string& remarks);
/// How long a frame then takes; 0: unknown.
double set_rate(Settings& settings, const NadirCameraWanted& wanted);
NadirExposing set_exposure(Settings& settings, double frame_us, const NadirCameraWanted& wanted,
                           std::string& remarks);

/// Afterwards.
void expose(Settings& settings, double ms, double gain);

}  // namespace nadir::capture::plugin
