// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What one sentence or packet of a sensor says.
#pragma once

#include <cstdint>
#include <optional>

#include "nadir/core/time.hpp"

namespace nadir::sensors {

/// WGS 84.
struct Position {
  double latitude_deg = 0, longitude_deg = 0;  ///< north and east positive
  std::optional<double> sigma;                 ///< horizontal, metres

  bool operator==(const Position&) const = default;
};

/// A value that was not given, was marked invalid by the sensor or cannot be true is absent.
/// Angles are radians of the body (FRD) to north-east-down, as in Attitude; headings within
/// [0, 2 pi).
struct Reading {
  /// Who of the senders on one input says so: the talker of a sentence, or message, system and
  /// component of a packet, each in a number of its own.
  std::uint32_t sender = 0;

  std::optional<double> roll, pitch;
  std::optional<double> heading;           ///< from true north
  std::optional<double> magnetic_heading;  ///< from magnetic north, corrected for deviation
  std::optional<double> variation;         ///< true minus magnetic, east positive, within +-pi
  std::optional<double> turn_rate;         ///< clockwise seen from above, radians per second
  std::optional<double> depth;             ///< of the vehicle below the surface, metres
  std::optional<double> pressure;          ///< absolute, of the water around, pascal
  std::optional<double> altitude;          ///< from the sounder to the seabed, metres
  std::optional<Position> position;
  std::optional<double> course;  ///< over ground, from true north
  std::optional<double> speed;   ///< over ground, metres per second
  std::optional<Time> utc;       ///< since the UNIX epoch
  std::optional<Time> uptime;    ///< of the sensor when it measured, by its own clock

  bool operator==(const Reading&) const = default;
};

}  // namespace nadir::sensors
