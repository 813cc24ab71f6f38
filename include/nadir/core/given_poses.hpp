// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Camera poses that another program found, in place of odometry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nadir/core/rigid3.hpp"

namespace nadir {

struct GivenPoses {
  std::string origin;  ///< the file or folder, for messages
  /// By image number; none where the program found no pose. In the frame `survey` when `is_survey`,
  /// else in one of the program's own choice.
  std::vector<std::optional<Rigid3>> map_from_camera;
  bool is_survey = false;  ///< z is up
  bool is_metric = false;  ///< lengths are metres
};

}  // namespace nadir
