// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the diver must hear of. The kinds are the closed list of alerts.jsonl.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nadir/core/time.hpp"

namespace nadir {

enum class AlertKind {
  tracking_lost,
  tracking_recovered,
  submap_started,
  submap_joined,
  not_planar,
  mosaic_restarted,
  scale_conflict,
  calibration_suspect,
  stereo_skew,
  camera_lost,
  camera_back,
  image_rejected,
  images_dropped,
  sensor_stale,
  storage,
  clock,
  load,
  storage_back,  // the last: journals hold their numbers
};

/// The name used in files and on the wire.
std::string_view to_string(AlertKind kind);

struct Alert {
  Time time = 0;
  std::optional<std::uint64_t> image;  ///< counted from 0 in input order
  AlertKind kind{};
  std::string message;  ///< what happened, to what
  std::string remedy;   ///< what the diver or surveyor can do
};

}  // namespace nadir
