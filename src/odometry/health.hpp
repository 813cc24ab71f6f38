// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How good an image and its orientation are, for health.csv.
#pragma once

#include "resection.hpp"

namespace nadir::odometry {

/// Of the picture.
Health health_of(const View& view, const Config& config);

/// Adds the image's tie points, and judges them.
void count(Health& health, const Map& map, const Resection& resection, const Config& config);

/// Adds those of a key frame.
void count(Health& health, const Map& map, int key_frame, const Config& config);

/// Of the shot's own image or one before it.
void tell(const Health& health, const View& view, Orientation& out);

/// Of a key frame that has its view.
void tell_health(const Map& map, int key_frame, const Config& config, Orientation& out);

}  // namespace nadir::odometry
