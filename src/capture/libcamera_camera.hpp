// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Cameras of libcamera, by a plugin that is loaded when one is asked for.
#pragma once

#include <filesystem>
#include <string>

#include "camera.hpp"

namespace nadir::capture {

/// $NADIR_PLUGINS, or where they are installed.
std::filesystem::path plugin_folder();

/// Begins to stream, by the newest nadir-libcamera-*.so in the folder whose libcamera is here. id:
/// the camera's, the end of just one, or "auto", the only one.
OpenedCamera open_libcamera(const std::string& id, const CameraMode& mode,
                            const std::filesystem::path& folder = plugin_folder());

}  // namespace nadir::capture
