// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What all sensors together say of the vehicle at the time of an image.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nadir/core/alert.hpp"
#include "nadir/core/frame.hpp"
#include "nadir/core/sensor_track.hpp"
#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

struct Config {
  std::string inputs;  ///< see parse_inputs; empty: no sensors but those of a folder

  // How long after the moment it is true a value arrives.
  double attitude_delay_s = 0;
  double depth_delay_s = 0;
  double altitude_delay_s = 0;

  double surface_pressure_hpa = 1013.25;  ///< of the air, for the depth by pressure
  double water_density = 1025;            ///< kilograms a cubic metre; lakes and pools: 1000
  /// True minus magnetic north, east positive; used while no sensor tells it. When it is set, the
  /// magnetic model of reference.origin is not asked.
  double magnetic_variation_deg = 0;

  std::string outputs;              ///< see parse_outputs; empty: nothing is sent
  std::uint8_t mavlink_system = 1;  ///< the vehicle's number, as which is sent

  /// Throws InputError naming the setting that is out of range, or an input that is malformed.
  void check() const;
};

enum class Quantity : std::uint8_t { tilt, heading, depth, altitude, position };
inline constexpr std::array kQuantities{Quantity::tilt, Quantity::heading, Quantity::depth,
                                        Quantity::altitude, Quantity::position};

/// Each quantity is taken from the sender that told it first, until that has been silent for 2 s;
/// of one sender, what it tells outright goes before what is worked out. Values that change faster
/// than a vehicle can are left out and told.
class VehicleState {
 public:
  /// names: of the inputs, for alerts.
  VehicleState(Config config, std::vector<std::string> names);

  /// time: of arrival, by the clock of the images; readings of one input come in order.
  void hear(std::size_t input, Time time, const Reading& reading);

  /// Fills in attitude, depth and altitude at frame.time: interpolated, or the newest value when it
  /// is at most 0.1 s older. Without roll and pitch, or without a heading, there is no attitude.
  void mark(Frame& frame) const;

  /// sensor_stale for what has been told before and is silent for 2 s, also when another sensor has
  /// taken over, and for what jumps; once, and again only after it was good for 10 s. now: by the
  /// clock of the images.
  [[nodiscard]] std::vector<Alert> new_alerts(Time now, std::optional<std::uint64_t> image);

  std::optional<Position> position(Time time) const;
  std::optional<double> variation() const { return variation_; }  ///< as a sensor told it last
  /// UTC minus the clock of the images, by the least delayed time a sensor has told.
  std::optional<Time> utc_offset() const { return utc_offset_; }

 private:
  /// Of an input, who tells a quantity: itself, or another (pressure, magnetic heading, a position
  /// without its sigma) that it is worked out from or that is worth less.
  struct Source {
    std::size_t input = 0;
    std::uint32_t sender = 0;
    bool lesser = false;
    bool operator==(const Source&) const = default;
  };

  /// One quantity's values, from one source at a time.
  struct Channel {
    SensorTrack track;
    std::optional<Source> source;
    Time heard = 0;                             ///< from that source
    std::optional<SensorTrack::Row> candidate;  ///< where values have jumped to
    int candidates = 0;                         ///< in a row that agree with it
    std::optional<Time> last_jump;              ///< when a value was left out
    std::optional<Time> told;             ///< when it was last found wanting, once an alert said so
    std::optional<Source> fallen_silent;  ///< before the source of now took over
  };

  /// The clock of a sender, which stamps its values, against ours. What comes is late by a varying
  /// time: the least late is believed.
  class Clock {
   public:
    Time time_of(Time arrival, Time uptime);

   private:
    std::optional<Time> offset_;  ///< ours minus its own
    Time arrival_ = 0, uptime_ = 0;
  };

  const Channel& channel(Quantity quantity) const {
    return channels_[static_cast<std::size_t>(quantity)];
  }
  struct Moment {
    std::size_t input = 0;
    std::uint32_t sender = 0;
    Time arrival = 0, time = 0;
    Moment earlier(double delay_s) const {
      return {input, sender, arrival, time - from_seconds(delay_s)};
    }
  };
  void add(Quantity quantity, Moment moment, bool lesser, const SensorTrack::Values& values);
  void hear_heading(const Moment& moment, const Reading& reading);
  void hear_depth(const Moment& moment, const Reading& reading);
  void hear_utc(const Moment& moment, Time utc);
  std::optional<SensorTrack::Values> at(Quantity quantity, Time time) const;

  Config config_;
  std::vector<std::string> names_;
  std::map<std::pair<std::size_t, std::uint32_t>, Clock> clocks_;  ///< by input, system, component
  std::array<Channel, kQuantities.size()> channels_;
  std::optional<double> variation_;
  std::optional<Time> utc_offset_;
  Time utc_heard_ = 0;
};

}  // namespace nadir::sensors
