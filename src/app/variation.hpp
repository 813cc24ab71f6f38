// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How far magnetic north is from true north, for the headings of live sensors.
#pragma once

#include <optional>

#include "config.hpp"

namespace nadir::app {

struct Variation {
  double degrees = 0;          ///< true minus magnetic north, east positive
  std::optional<Alert> alert;  ///< when the model says nothing of the day, without its time
};

/// By the magnetic model at reference.origin; utc: of the system's clock. None without an origin or
/// sensors, and when sensors.magnetic_variation_deg is set: who sets it knows better.
std::optional<Variation> variation_by_model(const Config& config, Time utc);

}  // namespace nadir::app
