// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How good an image and its orientation are, for health.csv and the page.
#pragma once

#include "resection.hpp"

namespace nadir::odometry {

/// Of the picture.
Health health_of(const View& view, const Config& config);

/// Adds the image's tie points.
void count(Health& health, const Map& map, const Resection& resection, const Config& config);

/// Adds those of a key frame.
void count(Health& health, const Map& map, int key_frame, const Config& config);

}  // namespace nadir::odometry
