// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the stages find, as told to autopilots and chart programs.
#pragma once

#include <optional>

#include "config.hpp"
#include "nadir/core/cloud.hpp"
#include "nadir/coverage/seen_ground.hpp"
#include "nadir/reference/geodetic.hpp"
#include "nadir/sensors/pose_output.hpp"

namespace nadir::app {

class Outputs {
 public:
  explicit Outputs(const Config& config);

  /// Sends the pose of the shot's image, if it has one.
  void process(const Orientation& orientation);
  /// Sends the ground of an image that has a plane, and every 5 s the outline of all, as coarse as
  /// a datagram needs it.
  void process(const Cloud& cloud);

 private:
  sensors::PoseOutput output_;
  coverage::SeenGround seen_;
  std::optional<reference::UtmGrid> grid_;  ///< with reference.origin
  Scale scale_;
  SurveyAxes axes_ = SurveyAxes::none;
  std::optional<Time> outlined_;
};

}  // namespace nadir::app
