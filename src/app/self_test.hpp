// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The checks before a dive that need cameras and sensors for themselves.
#pragma once

#include <chrono>
#include <vector>

#include "config.hpp"
#include "nadir/core/finding.hpp"

namespace nadir::app {

/// Whether each input is heard within a few seconds, and what it tells.
std::vector<Finding> check_sensors(const sensors::Config& config, std::chrono::seconds patience);

/// Cameras, light, focus, the pair and its calibration, on up to twenty images.
std::vector<Finding> check_cameras(const Config& config, std::chrono::seconds patience);

/// Whether the configured certificate can be used; nothing where none is.
std::vector<Finding> check_https(const serve::Config& config);

/// Whether something serves the page at this machine's port.
Finding check_page(const serve::Config& config);

}  // namespace nadir::app
