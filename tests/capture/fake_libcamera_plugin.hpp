// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a test and the plugin it loads share.
#pragma once

#include <cstddef>

#include "libcamera_plugin.h"

namespace nadir::capture {

struct FakePlugin {
  static constexpr std::size_t kPadding = 5;  ///< of a row

  // What it does.
  NadirCameraTaken next = NADIR_TAKEN_NOTHING;
  NadirCameraPicture picture{};
  NadirExposing exposing{};
  void (*opening)() = nullptr;  ///< called meanwhile

  // What was asked of it.
  NadirCameraWanted wanted{};
  bool open = false, stopped = false;
  int descriptor = -1, out = 0;  ///< pictures
  void* given_back = nullptr;
  double ms = 0, gain = 0;
};

}  // namespace nadir::capture

/// For dlsym(3): the first of two FakePlugins.
extern "C" void* fake_plugin();
