// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How good an image and its orientation are, for health.csv and the page.
#pragma once

#include "resection.hpp"

namespace nadir::odometry {

Health health_of(const View& view);

/// Adds the image's tie points.
void count(Health& health, const Resection& resection, const CameraModel& camera);

}  // namespace nadir::odometry
