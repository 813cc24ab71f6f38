// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How fast the ground moves in the images: motion blur is this times the exposure.
#pragma once

#include <memory>
#include <optional>

#include "nadir/core/window.hpp"

namespace nadir::app {

class ImageSpeed {
 public:
  /// px a second at the processed scale, by the newest two images with a pose and the tie points
  /// seen last; none while there are none, as without tracking.
  std::optional<double> observe(const Orientation& orientation);

 private:
  std::optional<ImagePose> before_;
  std::shared_ptr<const Window> window_;  ///< the last
};

}  // namespace nadir::app
