// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Why an image has no pose, in words a diver understands.
#pragma once

#include "features.hpp"
#include "nadir/odometry/visual_odometry.hpp"

namespace nadir::odometry {

enum class LossReason { blank_image, too_few_matches, too_large_motion };

/// When a map has been being started for long: why there is none yet.
enum class StartTrouble { no_motion, no_fit };
Alert no_map_yet_alert(const Frame& newest, StartTrouble trouble);

/// At the end of an input that gave no map; last: the newest image waited for.
Alert no_map_alert(const Frame& last);

/// A blank image is dark, bright or neither by config.weak_dark and config.weak_bright.
Alert loss_alert(const View& view, LossReason reason, const Config& config);

}  // namespace nadir::odometry
