// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every room's settings side by side, and the one table that names them for the file and the
// command line alike.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "guide_config.hpp"
#include "nadir/capture/source.hpp"
#include "nadir/mosaic2d/mosaicker.hpp"
#include "nadir/odometry/visual_odometry.hpp"
#include "nadir/plane/plane_fit.hpp"
#include "nadir/projection3d/plane_projection.hpp"
#include "nadir/record/dive.hpp"
#include "nadir/reference/survey_frame.hpp"
#include "nadir/revisit/revisit.hpp"
#include "nadir/sensors/vehicle_state.hpp"
#include "nadir/serve/web_server.hpp"

namespace nadir::app {

struct Config {
  capture::Config capture;
  odometry::Config odometry;
  reference::Config reference;
  revisit::Config revisit;
  plane::Config plane;
  mosaic2d::Config mosaic2d;
  projection3d::Config projection3d;
  PlanConfig plan;
  GuideConfig guide;
  record::Config record;
  sensors::Config sensors;
  serve::Config serve;

  /// Throws InputError naming the setting, the fault and the remedy.
  void check() const;
};

using Value = std::variant<bool, std::int64_t, double, std::string>;

/// One line of the table: a setting's name, meaning, and how to read and write it in a Config.
struct Setting {
  std::string key;  ///< room.key
  std::string meaning;
  std::function<Value(const Config&)> get;
  /// Throws InputError when the value has another type or is none of the choices.
  std::function<void(Config&, const Value&)> set;
};

const std::vector<Setting>& settings();

/// Sets by name; an unknown key is an InputError that names its nearest neighbour. where: file and
/// line, or the option.
void assign(Config& config, const std::string& key, const Value& value, const std::string& where);

}  // namespace nadir::app
