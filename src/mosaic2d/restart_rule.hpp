// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// When a plane has left the validity of the running mosaic (paper 3.4.1).
#pragma once

#include <cstdint>
#include <string>

#include "nadir/mosaic2d/mosaicker.hpp"
#include "plane_homography.hpp"

namespace nadir::mosaic2d {

/// What the rule looks at.
struct Stand {
  std::uint32_t submap = 0;
  Plane plane;
  Footprint footprint;
};

/// Compares with the stand that began the mosaic, never with the last one, so that a slow drift is
/// noticed and a return is none; a departure counts when it lasted `restart_after` images.
class RestartRule {
 public:
  RestartRule(const Config& config, const Stand& first) : config_(config), first_(first) {}
  /// The reason for a new mosaic; empty to go on.
  std::string reason(const Stand& stand);

 private:
  std::string departure(const Stand& stand) const;

  Config config_;
  Stand first_;
  int departed_ = 0;
};

}  // namespace nadir::mosaic2d
